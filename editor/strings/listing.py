"""Which words of the interface have no translation: `python -m editor.strings [LANGUAGE]`.

registries     menus, labels and tips of operations, titles of panels: these must all be there (`required`)
parameters     names, descriptions and choices of everything that gets a slider or a box by its declaration (`declared`)
engine         why passes are left out, titles of experiments, fixes of an import (`told`)
source code    what is written out in calls that show it: labels, tips, headings (`written`); f-strings as templates
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from editor import strings
from editor.builtin_operations import builtin_operations
from editor.strings.doors import HINTED, LABELS, TEXTS
from engine.core.param import Param

EDITOR = Path(__file__).resolve().parents[1]
EFFECTS = EDITOR.parent / "shaders" / "effects"
#: our own functions that show text: name -> places of it
SHOWING = {
    "tr": (0,), "text": (0,), "tooltip": (0,), "flow_text": (0, 2), "fitted_text": (0,), "section": (1,),
    "icon_button": (0, 1), "bare_button": (0,), "search_field": (2,), "property_row": (0, 1),
    "property_text": (0, 1, 2), "empty_state": (1, 2), "chip": (2,), "flow_button": (0, 1), "wide_button": (0, 1),
    "flow_icon": (2,), "wrapped_text": (0,),
    "combo": (0,), **dict.fromkeys(LABELS, (0,)), **{n: (p,) for n, p in TEXTS.items()},
    **dict.fromkeys(HINTED, (0, 1)),
}  # fmt: skip
#: words enough in a row that they were not left for their own sake
SENTENCE = re.compile(r"[A-Za-z]+(?: [A-Za-z]+){2,}")
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


def declared() -> dict[str, str]:
    """Text -> where: names, descriptions, groups and choices of settings, of the fields of lights, cameras and
    surroundings, and of the parameters, textures and features of the effects that come with the product."""
    from editor.panels.inspector_fields import CAMERA, ENVIRONMENT, LOOK
    from editor.panels.inspector_light import FIELDS
    from editor.widgets import pretty
    from engine.materials.effect import load_effect
    from engine.render.settings import RenderSettings
    from engine.scene.arrays import ArraySettings
    from engine.scene.scatter import ScatterSettings

    blocks: dict[str, Sequence[Param]] = {
        block.__name__: block.PARAMS for block in (RenderSettings, ArraySettings, ScatterSettings)
    }
    blocks |= {"camera": CAMERA, "environment": ENVIRONMENT, "look": LOOK, "light": tuple(FIELDS.values())}
    found: dict[str, str] = {}

    def add(where: str, *texts: str) -> None:
        for text in texts:
            if any(c.isalpha() for c in text):
                found.setdefault(text, where)

    def add_params(where: str, params: Sequence[Param]) -> None:
        for param in params:
            add(f"{where}.{param.name}", pretty(param.name), param.doc, param.group, *map(pretty, param.choices))

    for name, params in blocks.items():
        add_params(name, params)
    for path in sorted(EFFECTS.glob("*.effect.toml")):
        effect = load_effect(path)
        add_params(effect.name, effect.params)
        for slot in effect.textures:
            add(f"{effect.name}.{slot.name}", pretty(slot.name.removesuffix("_map")), slot.doc, slot.group)
        for feature in effect.features.values():
            add(f"{effect.name}.{feature.name}", pretty(feature.name), feature.doc)
    return found


def told() -> dict[str, str]:
    """Text -> where: what comes from under the panels and is shown as it is."""
    from editor.import_settings import FIXES
    from engine.experiments.harness.live import offers

    found = {offer.title: f"experiment {offer.name}" for offer in offers(device=None, scene_open=True)}
    for fix in FIXES:
        found |= dict.fromkeys((fix.label, fix.doc), f"fix {fix.id}")
    for path in sorted((EDITOR.parent / "engine" / "render").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and node.name == "needs":
                for line in (inner for inner in ast.walk(node) if isinstance(inner, ast.Return) and inner.value):
                    assert line.value is not None
                    found |= dict.fromkeys(_reasons(line.value), f"{path.name}:{line.lineno}")
    return {words: where for words, where in found.items() if clean(words)}


def _reasons(node: ast.expr) -> Iterator[str]:
    """The texts that `needs` may return, also those that it gives to a function."""
    yield from _texts(node)
    if isinstance(node, ast.IfExp) and isinstance(node.orelse, ast.Call):
        node = node.orelse
    if isinstance(node, ast.Call):
        for argument in node.args:
            yield from _texts(argument)


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
        yield "".join(map(_part, node.values))
    elif isinstance(node, ast.IfExp):
        yield from _texts(node.body)
        yield from _texts(node.orelse)


def _part(node: ast.expr) -> str:
    """A part of an f-string: itself, nothing for an icon, {} for any other value."""
    if isinstance(node, ast.Constant):
        return str(node.value)
    return "" if "icon" in ast.unparse(node).lower() else "{}"


def clean(words: str) -> str:
    """Without what translation leaves alone: identities behind ##, spaces at the ends."""
    shown = words.partition("##")[0].strip()
    return shown if any(c.isalpha() for c in shown.replace("{}", "")) else ""


def _translated(table: strings.Table, line: str) -> bool:
    """Whether it is, and not in part only, by the template of another."""
    found = table.translate(line)
    return found != line and (line in table.entries or SENTENCE.search(found) is None)


def missing(language: str, wanted: Mapping[str, str]) -> dict[str, str]:
    """What of `wanted` has no translation."""
    table = strings.load(language)

    def known(words: str) -> bool:
        return words in table.entries or all(
            not clean(line) or _translated(table, line.replace("{}", "7")) for line in words.split("\n")
        )

    return {words: where for words, where in wanted.items() if not known(words)}


def main() -> int:
    language = sys.argv[1] if len(sys.argv) > 1 else "zh"
    counts = []
    kinds = {
        "menus, operations and panels": required(),
        "parameters": declared(),
        "the engine": told(),
        "the source": written(),
    }
    for kind, found in kinds.items():
        lacking = missing(language, found)
        for words, where in lacking.items():
            print(f"{where}: {words!r}")
        counts.append((len(lacking), f"{len(found) - len(lacking)} of {len(found)} of {kind}"))
    print(f"{language}: {'; '.join(text for _, text in counts)}")
    return 1 if any(lacking for lacking, _ in counts) else 0
