"""The documents that are made from the registries: `python -m editor.documentation` writes them, `--check` compares.

docs/features.md      what one expects of an editor, and where it is: menu, key, palette, panel, command line
docs/operations.md    every operation with its keys and arguments
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path

from editor.builtin_operations import builtin_operations
from editor.features import FEATURES, Feature
from editor.navigation import PRESETS, Binding
from editor.operations import Operation, Operations
from engine.core.atomic import write_text

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
NOTE = "<!-- made by `python -m editor.documentation`; edit editor/features.py or the operations instead -->"


def features_text(operations: Operations) -> str:
    """docs/features.md. Raises KeyError where a row names an operation that there is not."""
    head = "| | Menu and palette | Keys | Panels | Command line | |\n|---|---|---|---|---|---|"
    first = [_row(f, operations) for f in FEATURES if f.first]
    rest = [_row(f, operations) for f in FEATURES if not f.first]
    missing = [f"- {f.name}: {f.missing}." for f in FEATURES if f.missing]
    return "\n".join([
        "# Where things are", "", NOTE, "",
        "Every entry can be typed into the command palette, run from the Python console and from `lucarna run`.", "",
        "## What must be there", "", head, *first, "", "## What else one expects", "", head, *rest, "",
        "## What is missing", "", *(missing or ["Nothing that these tables name."]), "",
    ])  # fmt: skip


def _row(feature: Feature, operations: Operations) -> str:
    entries = [operations[id] for id in feature.operations]
    where = "<br>".join(f"{o.menu + ' › ' if o.menu else ''}{o.label} `{o.id}`" for o in entries)
    keys = ", ".join(dict.fromkeys(f"`{o.shortcuts[0]}`" for o in entries if o.shortcuts))
    drags = [f"`{gesture(binding)}`" for motion in feature.motions for binding in first_bindings(motion)]
    commands = ", ".join(f"`lucarna {c}`" for c in feature.commands)
    cells = [feature.name, where, ", ".join([*([keys] if keys else []), *drags]), ", ".join(feature.panels), commands]
    return "| " + " | ".join([*(_escaped(c) for c in cells), feature.more]) + " |"


def first_bindings(motion: str) -> list[Binding]:
    """How the first keymap that has it begins a motion."""
    return [b for b in PRESETS["industry"] if b.motion == motion][:1]


def gesture(binding: Binding) -> str:
    """`Alt+left drag`."""
    held = "".join(f"{m.capitalize()}+" for m in ("ctrl", "alt", "shift") if m in binding.modifiers)
    return f"{held}{binding.button} {'click' if binding.motion == 'select' else 'drag'}"


def _escaped(text: str) -> str:
    return text.replace("|", "\\|")


def operations_text(operations: Operations) -> str:
    """docs/operations.md."""
    lines = [
        "# Operations", "", NOTE, "",
        'In the console and in scripts: `run("edit.move-by", offset=(1, 0, 0))`. Those without a menu are in the '
        "palette. Arguments without a default must be given.", "",
    ]  # fmt: skip
    group = ""
    for operation in sorted(operations, key=lambda o: o.id.split(".")[0]):
        part = operation.id.split(".")[0]
        if part != group:
            group = part
            lines += [
                f"## {part}",
                "",
                "| Operation | Label | Menu | Keys | Arguments | |",
                "|---|---|---|---|---|---|",
            ]
        lines.append(_operation_row(operation))
        following = [o for o in sorted(operations, key=lambda o: o.id.split(".")[0]) if o.id.split(".")[0] == part]
        if operation is following[-1]:
            lines.append("")
    return "\n".join(lines)


def _operation_row(operation: Operation) -> str:
    arguments = "<br>".join(
        f"`{a.usage()}`{' ' + a.unit if a.unit else ''}{' ' + a.doc if a.doc else ''}" for a in operation.arguments
    )
    keys = ", ".join(f"`{k}`" for k in operation.shortcuts)
    cells = [f"`{operation.id}`", operation.label, operation.menu, keys, arguments, operation.doc]
    return "| " + " | ".join(_escaped(c) for c in cells) + " |"


def pages() -> Mapping[Path, str]:
    """Path below docs -> text."""
    operations = builtin_operations()
    return {Path("features.md"): features_text(operations), Path("operations.md"): operations_text(operations)}


def stale(folder: Path = DOCS) -> list[Path]:
    """The documents that differ from what would be written."""
    return [
        path for path, text in pages().items()
        if not (folder / path).is_file() or (folder / path).read_text(encoding="utf-8") != text
    ]  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m editor.documentation", description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing; exit with 1 where something is stale")
    if parser.parse_args().check:
        old = stale()
        for path in old:
            print(f"docs/{path.as_posix()} is stale: run `python -m editor.documentation`", file=sys.stderr)
        return 1 if old else 0
    for path, text in pages().items():
        write_text(DOCS / path, text)
        print(f"docs/{path.as_posix()}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
