"""Operations that take what they do as arguments: for scripts, the console and the palette, without a pointer."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from editor.arguments import REQUIRED, Argument, living_nodes
from editor.camera_controls import from_matrix
from editor.editing_operations import reparent
from editor.focusing import add_focus_operation
from editor.operations import Operation, Operations
from editor.quality import add_quality_operations
from editor.session import Session
from editor.tables import FEATURES, QUEUE, TEXTURE, material_values
from engine.core.errors import LucarnaError, UsageError
from engine.math import quat, transform
from engine.render.one_sample import along

Run = Callable[..., None]
#: columns of the tables whose columns are not the fields of a record
NODE_COLUMNS = ("translation", "rotation", "scale", "visible", "name")


def add_direct_operations(ops: Operations) -> None:
    """Add them all to the registry."""
    add_quality_operations(ops)
    add_focus_operation(ops)

    def add(
        id: str, label: str, run: Run, *arguments: Argument, about: str = "",
        enabled: Callable[[Session], bool] = _has_document,
        sample: Callable[[Session, random.Random], dict[str, Any]] | None = None,
    ) -> None:  # fmt: skip
        ops.add(Operation(id, label, run, "", (), enabled, None, False, about, arguments, sample))

    def _export_keys(session: Session, path: Path) -> None:
        from editor.keymap import Keymap

        Keymap(ops, session.preferences).export_to(path.absolute())
        session.ui.notice = f"Keys written to {path.name}"

    def _import_keys(session: Session, path: Path) -> None:
        from editor.keymap import Keymap

        unknown = Keymap(ops, session.preferences).import_from(path)
        for id in unknown:
            session.messages.warn(f"The keymap has keys for {id}, which there is not", where=str(path))
        session.remember()

    add("file.open-path", "Open this path", _open, Argument("path", "path", doc="a project, folder, scene or model"),
        enabled=lambda s: True, about="As File, Open, without the dialog")  # fmt: skip
    add("file.save-to", "Save to this path", _save_to, Argument("path", "path", doc="a .scene.json file"),
        about="As File, Save as, without the dialog")  # fmt: skip

    add("help.export-keymap", "Export keys", _export_keys, Argument("path", "path", doc="a .json file"),
        enabled=lambda s: True, about="Preset and what was changed of it")  # fmt: skip
    add("help.import-keymap", "Import keys", _import_keys, Argument("path", "path", doc="what an export wrote"),
        enabled=lambda s: True, about="In the place of the changes of that preset")  # fmt: skip

    add("select.nodes", "Select these nodes", _select, Argument("nodes", "nodes", doc="names or rows"),
        about="In this order; the last is the primary one")  # fmt: skip
    add("select.matching", "Select by name", _select_matching, Argument("pattern", "text", doc="with * and ?"),
        about="Every node whose name fits a pattern such as wheel*")  # fmt: skip

    sel = _has_selection
    add("edit.move-by", "Move by", _move, Argument("offset", "vec3", unit="m", doc="in the parent's axes"),
        enabled=sel, about="The selected nodes, by metres")  # fmt: skip
    add("edit.turn-by", "Turn by", _turn, Argument("axis", "enum", "y", choices=("x", "y", "z")),
        Argument("degrees", "float", 90.0, -36000.0, 36000.0), enabled=sel,
        about="The selected nodes about their own origins, in the parent's axes")  # fmt: skip
    add("edit.scale-by", "Scale by", _scale, Argument("factor", "vec3", min=-1e6, max=1e6), enabled=sel,
        about="The selected nodes, along their own axes")  # fmt: skip
    add("edit.rename-to", "Rename to", _rename, Argument("name", "text"), enabled=sel, about="The primary node")
    add("edit.set-visible", "Set visible", _set_visible, Argument("visible", "bool", True), enabled=sel)
    add("edit.reparent", "Hang below", _reparent, Argument("parent", "node", doc="-1: the top of the tree"),
        enabled=sel, about="The selected nodes keep their places in the world")  # fmt: skip
    add("edit.set", "Set a value", _set, Argument("table", "enum", choices=_tables), Argument("column", "text"),
        Argument("value", "value"), Argument("rows", "value", None, doc="rows of the table; None: of the selection"),
        sample=_sample_set,
        about="A column of any table: nodes, lights, cameras, materials, environment, look")  # fmt: skip

    add("view.look", "Look from and at", _look, Argument("eye", "vec3", unit="m"), Argument("target", "vec3", unit="m"),
        Argument("fov", "float", 0.0, 0.0, 170.0, unit="deg", doc="vertical; 0 keeps it"),
        about="Place the viewport's camera")  # fmt: skip
    add("view.set", "Set a render setting", _set_setting, Argument("name", "enum", choices=_settings),
        Argument("value", "value"), sample=_sample_setting, about="One of `--set`'s, undone like an edit")  # fmt: skip
    add("play.seek", "Go to a time", lambda session, time: session.seek(time),
        Argument("time", "float", REQUIRED, 0.0, 1e6, unit="s"))  # fmt: skip


def _open(session: Session, path: Path) -> None:
    session.open(path)


def _save_to(session: Session, path: Path) -> None:
    if not path.name.endswith(".scene.json"):
        raise UsageError(f"{path.name!r} is no name of a scene", hint="a scene's name ends with .scene.json")
    session.save(path.absolute())


def _select(session: Session, nodes: Sequence[int]) -> None:
    assert session.document is not None
    session.document.selection = tuple(dict.fromkeys(row for row in nodes if row >= 0))


def _select_matching(session: Session, pattern: str) -> None:
    from fnmatch import fnmatchcase

    assert session.document is not None
    names = session.document.runtime.scene.nodes.name
    session.document.selection = tuple(r for r in living_nodes(session) if fnmatchcase(names[r], pattern))


def _move(session: Session, offset: tuple[float, float, float]) -> None:
    document = session.document
    assert document is not None
    before = document.tables["nodes"].read("translation", document.selection)
    after = [tuple(a + b for a, b in zip(place, offset, strict=True)) for place in before]
    session.edit("nodes", "translation", document.selection, after, label=f"Move {_what(session)}")


def _turn(session: Session, axis: str, degrees: float) -> None:
    document = session.document
    assert document is not None
    turn = quat.from_axis_angle(np.eye(3)["xyz".index(axis)], math.radians(degrees))
    before = np.asarray(document.tables["nodes"].read("rotation", document.selection), np.float64)
    after = quat.normalize(quat.multiply(turn, before))
    session.edit("nodes", "rotation", document.selection, list(after), label=f"Turn {_what(session)}")


def _scale(session: Session, factor: tuple[float, float, float]) -> None:
    document = session.document
    assert document is not None
    before = document.tables["nodes"].read("scale", document.selection)
    after = [tuple(a * b for a, b in zip(size, factor, strict=True)) for size in before]
    session.edit("nodes", "scale", document.selection, after, label=f"Scale {_what(session)}")


def _rename(session: Session, name: str) -> None:
    assert session.document is not None
    row = session.document.primary
    if not name.strip():
        raise UsageError("a node needs a name")
    session.edit("nodes", "name", [row], [name.strip()], label=f"Rename {session.node_name(row)}")


def _set_visible(session: Session, visible: bool) -> None:
    assert session.document is not None
    session.set_visible(session.document.selection, visible)


def _reparent(session: Session, parent: int) -> None:
    assert session.document is not None
    reparent(session, session.document.selection, parent)


def _set(session: Session, table: str, column: str, value: Any, rows: Any) -> None:
    """Raises UsageError for what the table does not take."""
    document = session.document
    assert document is not None
    chosen = [int(r) for r in rows] if rows is not None else _rows(session, table)
    try:
        document.edit(table, column, chosen, [value] * len(chosen))
    except LucarnaError:
        raise
    except (AttributeError, KeyError, IndexError, TypeError, ValueError) as error:
        raise UsageError(f"{table}.{column} of {chosen} cannot be {value!r}: {error}") from error


def _rows(session: Session, table: str) -> list[int]:
    """The rows of `table` that the selection means."""
    from editor.material_operations import selected_materials

    document = session.document
    assert document is not None
    if table == "nodes":
        return list(document.selection)
    if table == "materials":
        return selected_materials(session)
    if table in ("lights", "cameras"):
        kind = getattr(document.runtime.scene, table)
        return [int(r) for r in np.flatnonzero(kind.alive & np.isin(kind.node, document.selection))]
    return [0]


def _look(session: Session, eye: tuple[float, float, float], target: tuple[float, float, float], fov: float) -> None:
    distance = math.dist(eye, target)
    if distance <= 1e-9:
        raise UsageError("eye and target are the same point", hint="give two points that are apart")
    up = (0.0, 1.0, 0.0) if abs(eye[1] - target[1]) < 0.999999 * distance else (0.0, 0.0, -1.0)
    matrix = transform.look_at(np.array(eye), np.array(target), np.array(up))
    session.camera = from_matrix(matrix, distance, math.radians(fov) if fov else session.camera.yfov)


def _set_setting(session: Session, name: str, value: Any) -> None:
    known = {p.name: p for p in session.settings.PARAMS}
    chosen = {name: known[name].check(value)}
    more = along(chosen, int(getattr(session.settings, "samples", 1)))
    session.apply_settings({**chosen, **more}, f"Set {name.replace('_', ' ')}")


def _sample_setting(session: Session, dice: random.Random) -> dict[str, Any]:
    param = dice.choice(session.settings.PARAMS)
    return {"name": param.name, "value": _nudged(getattr(session.settings, param.name), dice, param.choices)}


def _sample_set(session: Session, dice: random.Random) -> dict[str, Any]:
    """A column that there is, and a value near the one it has, or a wild one."""
    document = session.document
    assert document is not None
    table = dice.choice(_tables(session))
    scene = document.runtime.scene
    columns: Sequence[str] = NODE_COLUMNS
    rows = living_nodes(session)
    if table in ("lights", "cameras"):
        kind = getattr(scene, table)
        rows = [int(r) for r in np.flatnonzero(kind.alive)]
        columns = tuple(type(kind.asset(rows[0])).__dataclass_fields__) if rows else ()
    elif table in ("environment", "look"):
        rows, columns = [0], tuple(type(getattr(scene, table)).__dataclass_fields__)
    elif table == "animation":
        rows, columns = [0], ("drive", "root_motion", "text")
    elif table == "materials":
        rows = sorted({int(m) for m in scene.instances.material[scene.instances.alive] if m >= 0})
        if rows:
            record = document.runtime.residency.material(rows[0])
            slots = [f"{TEXTURE}{slot.name}" for slot in record.effect.textures]
            columns = [*(p.name for p in record.effect.params), FEATURES, QUEUE, *slots]
    elif table == "objects":
        rows = sorted({int(n) for n in scene.instances.node[scene.instances.alive]})
        return _sample_object(session, dice, rows)
    elif table not in ("nodes", "animation", "materials"):
        rows = []
    if not rows or not columns:
        return {"table": "nodes", "column": "visible", "value": False, "rows": []}
    column, row = dice.choice(list(columns)), dice.choice(rows)
    now = document.tables[table].read(column, (row,))[0]
    return {"table": table, "column": column, "value": _nudged(now, dice), "rows": [row]}


def _sample_object(session: Session, dice: random.Random, rows: Sequence[int]) -> dict[str, Any]:
    """A parameter of the first material of one object, or that it says nothing of it."""
    assert session.document is not None
    if not rows:
        return {"table": "nodes", "column": "visible", "value": False, "rows": []}
    row, scene = dice.choice(list(rows)), session.document.runtime.scene
    part = next(i for i, node in enumerate(scene.instances.node) if int(node) == row)
    values = material_values(session.document.runtime.residency, int(scene.instances.material[part]))
    name = dice.choice(sorted(values))
    value = None if dice.random() < 0.3 else _nudged(values[name], dice)
    return {"table": "objects", "column": f"0:{name}", "value": value, "rows": [row]}


def _nudged(value: Any, dice: random.Random, choices: Sequence[str] = ()) -> Any:
    """Something of `value`'s kind that differs from it, or now and then something that is not of its kind."""
    if dice.random() < 0.05:
        return dice.choice((None, "odd", -1, math.nan, math.inf, 1e300, (), ("a", "b")))
    if isinstance(value, bool):
        return not value
    if isinstance(value, str):
        return dice.choice(choices) if choices else dice.choice((value, f"{value[:20]} 2", "木"))
    if isinstance(value, (int, float)):
        return type(value)(dice.choice((value * 2, value + 1, 0, value * 0.5)))
    if isinstance(value, tuple):
        return tuple(_nudged(v, dice) for v in value)
    return value


def _tables(session: Session) -> Sequence[str]:
    return tuple(t for t in session.document.tables if t != "settings") if session.document is not None else ()


def _settings(session: Session) -> Sequence[str]:
    return tuple(p.name for p in session.settings.PARAMS)


def _what(session: Session) -> str:
    assert session.document is not None
    rows = session.document.selection
    return session.node_name(rows[0]) if len(rows) == 1 else f"{len(rows)} nodes"


def _has_document(session: Session) -> bool:
    return session.document is not None


def _has_selection(session: Session) -> bool:
    return session.document is not None and bool(session.document.selection)
