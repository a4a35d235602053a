"""A process that does random operations until it is killed: `python -m tests.fuzz.operation_child JSON`.

It first restores what the one before it left, and compares: the content, and every state that undo and redo reach."""

from __future__ import annotations

import json
import os
import random
import signal
import sys
import traceback
from pathlib import Path
from typing import IO, Any

from editor import journal, recovering, tabs
from editor.commands.replacement import FileStep, Replacement
from editor.session import Session
from tests.fuzz import operation_stage as stage
from tests.fuzz.operation_model import Broken, Model, Watched, models_of
from tests.fuzz.operation_walk import Walk


def main() -> None:
    order: dict[str, Any] = json.loads(sys.argv[1])
    folder = Path(order["folder"])
    os.environ["LUCARNA_CACHE"] = str(folder / "cache")
    answer: dict[str, Any] = {"done": 0, "problem": "", "what": ""}
    with (folder / "trace.jsonl").open("a", encoding="utf-8") as trace:
        try:
            _walk(order, folder, trace, answer)
        except Exception:
            answer["problem"] = traceback.format_exc()
    _report(folder, answer)
    os._exit(1 if answer["problem"] else 0)


def _walk(order: dict[str, Any], folder: Path, trace: IO[str], answer: dict[str, Any]) -> None:
    homes = [folder / name for name in ("stage", "second", "third")]
    for number, home in enumerate(homes[:2]):
        stage.write_stage(home, animated=order["animated"] != (number == 1))
    stage.write_source(homes[2])
    session = stage.open_session(folder)
    walk = Walk(session, trace, homes)
    answer["restored"] = _restore(session, walk, folder)
    walk.keep_up()
    for home in [home for home in homes if all(w.home != home for w in walk.watched)][:1]:
        walk.open(home)
        walk.keep_up()
    dice = random.Random(order["seed"])
    kill_at, kill_how = order["kill_at"], order["kill_how"]
    events = 0

    def after_event(what: str) -> None:
        nonlocal events
        events += 1
        if kill_how == "event" and events == kill_at:
            _die(folder, answer, walk, session, torn=False)

    walk.after_event = after_event
    for number in range(order["count"]):
        answer["done"] = number
        answer["what"] = walk.step(dice)
        if number % 40 == 39:
            for written, _tab in tabs.journals(session):
                written.snapshot()
        if kill_how in ("step", "torn") and number == kill_at:
            _die(folder, answer, walk, session, torn=kill_how == "torn")
    answer["done"] = order["count"]
    _die(folder, answer, walk, session, torn=False)


def _restore(session: Session, walk: Walk, folder: Path) -> int:
    """Recover what a killed process left; returns how many documents that were. Raises Broken."""
    models = models_of(folder / "trace.jsonl")
    pending = {recovery.path.name: recovery for recovery in journal.pending(folder / "recovery")}
    last = folder / "last.json"
    told = json.loads(last.read_text(encoding="utf-8")) if last.is_file() else {}
    for name in pending.keys() - told.keys():
        raise Broken(f"the journal {name} is left of no document")
    for name, said in told.items():
        if name in pending:
            _restore_one(session, walk, pending[name], said, models.get(said["key"]))
        elif said["dirty"] and not said["open"]:
            raise Broken(
                f"unsaved edits of {said['name']} were there when the process was killed, and are not to restore"
            )
    walk.forget_all(key for key in models if key not in {w.key for w in walk.watched})
    return len(pending)


def _restore_one(
    session: Session, walk: Walk, pending: journal.Recovery, said: dict[str, Any], model: Model | None
) -> None:
    if not recovering.recover(session, pending):
        raise Broken(f"not restored: {session.failure}")
    document = session.document
    assert document is not None
    entries = [len(document.history.entries), len(document.history.undone)]
    if entries != said["entries"] and not said["files"]:
        raise Broken(f"{said['entries']} entries done and undone were there, {entries} are restored")
    if stage.scene_bytes(document).hex() != said["bytes"]:
        raise Broken("the restored scene would be saved as other bytes")
    state = Watched("", document, Path()).content()
    if said["content"] not in ("", state):
        raise Broken(f"restored is {state}, and was {said['content']}")
    if document.dirty != said["dirty"] and not said["open"]:
        raise Broken(f"unsaved was {said['dirty']}, and is {document.dirty}")
    if said["files"] or model is None:
        walk.watch(document, key=said["key"])
        return
    model.follow({"e": "end", "done": entries[0], "undone": entries[1], "state": state})
    walk.watch(document, key=said["key"], model=model)
    at = model.at
    document.history.go_to(0)  # the walk compares each state on the way
    document.history.go_to(len(model.states) - 1)
    document.history.go_to(at)


def _die(folder: Path, answer: dict[str, Any], walk: Walk, session: Session, *, torn: bool) -> None:
    """Be killed now. `torn`: half a line of the journal in front had reached the disk."""
    answer["counts"], answer["open"] = walk.counts, walk.most
    _report(folder, answer)
    told: dict[str, Any] = {}
    watched_of = {watched.document: watched for watched in walk.watched}
    for written, _tab in tabs.journals(session):
        document = written.document
        history, watched = document.history, watched_of.get(document)
        told[written.path.name] = {
            "key": watched.key if watched else "", "name": document.name,
            "content": watched.content() if watched else "",
            # the replay ends the gesture; one that had come back to where it began leaves no entry then
            "entries": [sum(e.changes for e in history.entries), len(history.undone)], "dirty": document.dirty,
            "bytes": stage.scene_bytes(document).hex(),
            # a drag that was killed where it had come back to its beginning counts as unsaved until it ends
            "open": bool(history.entries) and not history.entries[-1].changes,
            # what was done to files is done, and no part of a replay: the restored history is a shorter one
            "files": sum(isinstance(e, (Replacement, FileStep)) for e in (*history.entries, *history.undone)),
        }  # fmt: skip
    (folder / "last.json").write_text(json.dumps(told), encoding="utf-8")
    if torn and session.journal is not None:
        with session.journal.path.open("ab") as file:
            file.write(b'{"e":"do","c":{"table":"nodes","colu')
    os.kill(os.getpid(), signal.SIGKILL)


def _report(folder: Path, answer: dict[str, Any]) -> None:
    with (folder / "answers.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps(answer) + "\n")
        file.flush()
        os.fsync(file.fileno())


if __name__ == "__main__":
    main()
