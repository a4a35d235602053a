"""Which words of the interface have no translation: `python -m editor.strings [LANGUAGE]`.

registries     menus, labels and tips of operations, titles of panels: these must all be there (`required`)
source code    what is written out in calls that show it: labels, tips, headings (`written`); f-strings as templates
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from editor import strings
from editor.builtin_operations import builtin_operations
from editor.strings.doors import HINTED, LABELS, TEXTS

EDITOR = Path(__file__).resolve().parents[1]
#: our own functions that show text: name -> places of it
SHOWING = {
    "tr": (0,), "text": (0,), "tooltip": (0,), "flow_text": (0, 2), "fitted_text": (0,), "section": (1,),
    "icon_button": (0, 1), "bare_button": (0,), "search_field": (2,), "property_row": (0, 1),
    "property_text": (0, 1, 2),
    "empty_state": (1, 2), "combo": (0,), **dict.fromkeys(LABELS, (0,)), **{n: (p,) for n, p in TEXTS.items()},
    **dict.fromkeys(HINTED, (0, 1)),
}  # fmt: skip
#: attributes that hold what is shown
NOTICES = ("notice", "status_hint")


def required() -> dict[str, str]:
    """Text -> where: everything of the registries."""
    from editor.menus import MENUS

    found = dict.fromkeys(MENUS, "menu")
    for operation in builtin_operations():
        found.setdefault(operation.label, operation.id)
        if operation.doc:
            found.setdefault(operation.doc, operation.id)
    for title in panel_titles():
        found.setdefault(title, "panel")
    return found


def panel_titles() -> list[str]:
    """Without importing imgui: what the panels' classes say."""
    titles = []
    for path in sorted((EDITOR / "panels").glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            named = isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name) and node.target.id == "title"
            value = node.value if named and isinstance(node, ast.AnnAssign) else None
            if isinstance(value, ast.Constant) and isinstance(value.value, str):
                titles.append(value.value)
    return titles


def written() -> dict[str, str]:
    """Text -> file:line: what the editor's source shows."""
    found: dict[str, str] = {}
    for path in sorted(EDITOR.rglob("*.py")):
        for line, words in _shown(ast.parse(path.read_text(encoding="utf-8"))):
            cleaned = clean(words)
            if cleaned:
                found.setdefault(cleaned, f"editor/{path.relative_to(EDITOR).as_posix()}:{line}")
    return found


def _shown(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            for place in SHOWING.get(name, ()):
                if len(node.args) > place:
                    yield from ((node.lineno, words) for words in _texts(node.args[place]))
        elif isinstance(node, ast.Assign) and any(
            isinstance(target, ast.Attribute) and target.attr in NOTICES for target in node.targets
        ):
            yield from ((node.lineno, words) for words in _texts(node.value))


def _texts(node: ast.expr) -> Iterator[str]:
    """The texts that an expression may be; an f-string with {} for what is filled in."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, ast.JoinedStr):
        parts = [p.value if isinstance(p, ast.Constant) and isinstance(p.value, str) else "{}" for p in node.values]
        yield "".join(parts)
    elif isinstance(node, ast.IfExp):
        yield from _texts(node.body)
        yield from _texts(node.orelse)


def clean(words: str) -> str:
    """Without what translation leaves alone: identities behind ##, icons and placeholders at the ends."""
    shown = words.partition("##")[0].strip()
    while shown.startswith("{}"):  # an icon
        shown = shown[2:].strip()
    return shown if any(c.isalpha() for c in shown.replace("{}", "")) else ""


def missing(language: str, wanted: Mapping[str, str]) -> dict[str, str]:
    """What of `wanted` has no translation."""
    table = strings.load(language)

    def known(words: str) -> bool:
        return words in table.entries or all(
            not clean(line) or table.translate(line.replace("{}", "7")) != line.replace("{}", "7")
            for line in words.split("\n")
        )

    return {words: where for words, where in wanted.items() if not known(words)}


def main() -> int:
    language = sys.argv[1] if len(sys.argv) > 1 else "zh"
    names, source = required(), written()
    lacking, open_ones = missing(language, names), missing(language, source)
    for words, where in {**lacking, **open_ones}.items():
        print(f"{where}: {words!r}")
    print(
        f"{language}: {len(names) - len(lacking)} of {len(names)} of menus, operations and panels; "
        f"{len(source) - len(open_ones)} of {len(source)} in the source"
    )
    return 1 if lacking else 0
