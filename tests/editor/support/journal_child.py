"""A process that edits and waits to be killed: `journal_child.py FOLDER EDITS`. It prints the state it reached."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "editor" / "support")]

from edited_stage import act, document, state, without_view  # noqa: E402  (the path is set above)

from editor.journal import Journal  # noqa: E402  (needs the path above)


def fingerprint(doc: object) -> str:
    """The document's content as text that two processes can compare."""
    return repr(without_view(state(doc)))  # type: ignore[arg-type]  # a Document; named loosely to keep imports few


def main() -> None:
    folder, edits = Path(sys.argv[1]), int(sys.argv[2])
    doc = document()
    doc.source = doc.scene_path = folder / "stage.scene.json"
    doc.scene_path.write_text("{}\n")
    journal = Journal(doc, folder / "recovery")
    kinds = ["structure", "move", "name", "light", "undo", "redo", "hide"]
    for i in range(edits):
        act(doc, kinds[(i * 7919) % len(kinds)], i * 104729)
        if i == edits // 2:
            journal.snapshot()
    print(json.dumps({"state": fingerprint(doc), "entries": [e.describe() for e in doc.history.entries]}), flush=True)
    time.sleep(60)


if __name__ == "__main__":
    main()
