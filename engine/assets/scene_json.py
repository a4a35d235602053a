"""`*.scene.json`: one node a line, keys sorted, defaults left out, floats in their shortest exact form.

    {"schema": "lucarna.scene/1", "name": …, "nodes": [
    {"name": "root"},
    {"name": "lamp", "parent": 0, "light": {…}}
    ], …}

The same scene always gives the same text, so version control shows one changed line for one changed node.
"""

from __future__ import annotations

import dataclasses
import json
import math
import re
from pathlib import Path
from typing import Any

from engine.assets.mapping import map_file
from engine.assets.records import (
    Bad,
    Record,
    boolean,
    choice,
    did_you_mean,
    integer,
    items,
    mapping,
    number,
    optional,
    plain_lists,
    string,
    string_map,
    vector,
)
from engine.assets.scene import (
    BookmarkAsset,
    CameraAsset,
    EnvironmentAsset,
    LightAsset,
    LookAsset,
    MeshRef,
    NodeAsset,
    SceneAsset,
)
from engine.core.atomic import write_text
from engine.core.errors import FormatError, InputError, Place
from engine.core.findings import Findings

SCHEMA = "lucarna.scene/1"
MAX_BYTES = 1 << 30

#: |q|^2 may be off by this before a rotation counts as not normalised; float32 sources stay exactly as they are
UNIT_TOLERANCE = 1e-5

_COLOR = vector(3, number(0.0))
_ANGLE = number(-1e6, 1e6)

_CAMERA = Record(
    CameraAsset,
    {
        "type": choice("perspective", "orthographic"),
        "yfov": number(0.0, math.pi, above=True),
        "ymag": number(0.0, above=True),
        "znear": number(0.0),
        "zfar": number(0.0),
        "aspect": number(0.0),
    },
)
_LIGHT = Record(
    LightAsset,
    {
        "type": choice("directional", "point", "spot", "rectangle", "disk"),
        "color": _COLOR,
        "intensity": number(0.0),
        "range": number(0.0),
        "inner_angle": number(0.0, math.pi),
        "outer_angle": number(0.0, math.pi),
        "width": number(0.0),
        "height": number(0.0),
        "two_sided": boolean,
        "temperature": number(0.0),
        "profile": string,
        "casts_shadow": boolean,
        "radius": number(0.0),
    },
)


def _param_value(value: Any) -> Any:
    """What a material's parameter may be: a number, a truth, a word, or 2 to 4 numbers."""
    if isinstance(value, (bool, str)):
        return value
    if isinstance(value, list):
        if not 2 <= len(value) <= 4:
            raise Bad(f"{len(value)} numbers; a parameter has 2 to 4, or is one number")
        return vector(len(value))(value)
    return number()(value)


def _overrides(value: Any) -> dict[str, Any]:
    found = {}
    for name, given in mapping(value).items():
        try:
            found[name] = _param_value(given)
        except Bad as bad:
            raise bad.under(name) from None
    return found


_MESH = Record(
    MeshRef,
    {"file": string, "index": integer(0), "name": string, "materials": items(string), "overrides": items(_overrides)},
)
_NODE = Record(
    NodeAsset,
    {
        "name": string,
        "parent": integer(-1),
        "translation": vector(3),
        "rotation": vector(4),
        "scale": vector(3),
        "matrix": optional(vector(16)),
        "visible": boolean,
        "mesh": optional(_MESH.read),
        "camera": optional(_CAMERA.read),
        "light": optional(_LIGHT.read),
        "joints": items(integer(0)),
        "weights": items(number()),
        "clip_node": optional(integer(-1)),
        "placed": boolean,
        "extras": mapping,
    },
    {"mesh": _MESH, "camera": _CAMERA, "light": _LIGHT},
)
_ENVIRONMENT = Record(
    EnvironmentAsset,
    {
        "kind": choice("sky", "studio", "uniform", "image", "none"),
        "path": string,
        "color": _COLOR,
        "intensity": number(0.0),
        "rotation": _ANGLE,
        "background": choice("environment", "color"),
        "background_color": _COLOR,
        "background_blur": number(0.0, 1.0),
        "sun_elevation": number(-math.pi / 2, math.pi / 2),
        "sun_azimuth": _ANGLE,
        "sun_illuminance": number(0.0),
        "turbidity": number(1.0, 20.0),
    },
)
_LOOK = Record(LookAsset, {"exposure": number(-100.0, 100.0), "tone_map": choice("agx", "aces", "neutral", "none")})
_BOOKMARK = Record(
    BookmarkAsset,
    {
        "number": integer(1),
        "target": vector(3),
        "yaw": _ANGLE,
        "pitch": _ANGLE,
        "roll": _ANGLE,
        "distance": number(1e-6),
        "yfov": number(1e-3, 3.14),
        "orthographic": boolean,
    },
)
_SCENE = Record(
    SceneAsset,
    {
        "name": string,
        "nodes": items(_NODE.read),
        "clips": items(string),
        "environment": _ENVIRONMENT.read,
        "look": _LOOK.read,
        "active_camera": integer(-1),
        "animation": string,
        "drive": choice("", "clips", "timeline", "states"),
        "bookmarks": items(_BOOKMARK.read),
        "provenance": string_map,
    },
    {"environment": _ENVIRONMENT, "look": _LOOK, "bookmarks": _BOOKMARK},
)


def read_scene(path: Path, findings: Findings | None = None) -> SceneAsset:
    """Read and check a scene file.

    A rotation that is not of unit length is normalised and noted in `findings` (`scene.rotation`).
    Raises InputError when it cannot be read; FormatError with line and column where it is not JSON, with the object
    path (`nodes[3].parent`) where a value is wrong.
    """
    data = map_file(path)
    if len(data) > MAX_BYTES:
        raise FormatError(f"is {len(data)} bytes; a scene may have {MAX_BYTES}", where=path)
    return parse_scene(bytes(data), str(path), findings)


def parse_scene(raw: bytes | str, file: str, findings: Findings | None = None) -> SceneAsset:
    """The same from text; `file` names it in messages."""
    try:
        data = json.loads(raw)
    except json.JSONDecodeError as error:
        raise FormatError(f"not valid JSON: {error.msg}", where=Place(file, error.lineno, error.colno)) from error
    except (UnicodeDecodeError, RecursionError, ValueError) as error:
        raise FormatError(f"not valid JSON: {error}", where=file) from error
    try:
        found = data.pop("schema", None) if isinstance(data, dict) else None
        if found != SCHEMA:
            raise Bad(f"schema is {found!r}, expected {SCHEMA!r}", "schema")
        scene = _SCENE.read(data)
        check_scene(scene)
    except Bad as bad:
        raise FormatError(_named(bad, data), where=Place(file, path=bad.path), hint=bad.hint) from None
    for index, node in enumerate(scene.nodes):
        _normalise(index, node, findings)
    return scene


def read_surroundings(data: Any) -> tuple[EnvironmentAsset, LookAsset]:
    """Environment and look from `{"environment": {…}, "look": {…}}`, both optional, as a scene file has them.

    For sources that bring their look along. Raises Bad."""
    for key in mapping(data):
        if key not in ("environment", "look"):
            raise Bad("unknown key", key, did_you_mean(key, ("environment", "look")))
    scene = _SCENE.read({"name": "", **data})
    return scene.environment, scene.look


def write_scene(path: Path, scene: SceneAsset) -> None:
    """Write `scene` atomically after checking it. Raises FormatError, OutputError."""
    write_text(path, format_scene(scene, str(path)))


def format_scene(scene: SceneAsset, file: str = "") -> str:
    """The text of a scene file. Raises FormatError when a value is not allowed in one."""
    try:
        check_scene(scene)
        head = dataclasses.replace(scene, nodes=[])
        data: dict[str, Any] = {"schema": SCHEMA, "nodes": [], **_SCENE.write(head)}
        nodes = [_node(index, node) for index, node in enumerate(scene.nodes)]
    except Bad as bad:
        raise FormatError(bad.message, where=Place(file, path=bad.path), hint=bad.hint) from None
    lines = []
    for key in sorted(data):
        if key == "nodes" and nodes:
            text = ",\n".join(_dumps(node, Place(file, path=f"nodes[{i}]")) for i, node in enumerate(nodes))
            lines.append(f'"nodes": [\n{text}\n]')
        elif key != "nodes":
            lines.append(f"{json.dumps(key)}: {_dumps(data[key], Place(file, path=key))}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


#: what `check_field` knows, by the name that an editor's table has
_RECORDS: dict[str, Record[Any]] = {
    "nodes": _NODE, "lights": _LIGHT, "cameras": _CAMERA, "environment": _ENVIRONMENT, "look": _LOOK,
}  # fmt: skip


def check_field(kind: str, field: str, value: Any) -> None:
    """Raise InputError where a scene file could not say that `field` of a node, light, camera, the environment or the
    look is `value`. Kinds that no scene file has pass."""
    record = _RECORDS.get(kind)
    if record is None:
        return
    try:
        if field not in record.checks:
            raise Bad("is not known", hint=did_you_mean(field, record.checks))
        record.checks[field](plain_lists(value))
        if kind == "nodes" and field == "rotation" and not any(value):
            raise Bad("has length zero", hint="0, 0, 0, 1 is no rotation")
    except Bad as bad:
        raise InputError(f"{field}: {bad.message}", hint=bad.hint) from None


def check_scene(scene: SceneAsset) -> None:
    """Raise Bad where an index leads out of the scene or a parent comes after its child."""
    count = len(scene.nodes)
    for index, node in enumerate(scene.nodes):
        if not -1 <= node.parent < index:
            raise Bad(f"parent {node.parent} does not come before node {index}", f"nodes[{index}].parent")
        for joint in node.joints:
            if not 0 <= joint < count:
                raise Bad(f"joint {joint} is outside the {count} nodes", f"nodes[{index}].joints")
        if not any(node.rotation):
            place, hint = f"nodes[{index}].rotation", "set it to [0, 0, 0, 1], which is none"
            raise Bad("the rotation has length zero", place, hint)
    if scene.active_camera >= count:
        raise Bad(f"{scene.active_camera} is outside the {count} nodes", "active_camera")
    if scene.active_camera >= 0 and scene.nodes[scene.active_camera].camera is None:
        raise Bad(f"node {scene.active_camera} has no camera", "active_camera")


def _named(bad: Bad, data: Any) -> str:
    """The message with the name of the node it is about: people look for names, not for numbers."""
    match = re.match(r"nodes\[(\d+)\]", bad.path)
    try:
        name = data["nodes"][int(match[1])]["name"] if match else None
    except (LookupError, TypeError):
        name = None
    return f"node {name!r}: {bad.message}" if isinstance(name, str) else bad.message


def _normalise(index: int, node: NodeAsset, findings: Findings | None) -> None:
    length = math.hypot(*node.rotation)
    if abs(length * length - 1.0) <= UNIT_TOLERANCE:
        return
    x, y, z, w = (v / length for v in node.rotation)
    node.rotation = (x, y, z, w)
    if findings is not None:
        findings.warn(
            "scene.rotation", f"node {node.name!r}: rotation of length {length:g} was normalised",
            f"nodes[{index}].rotation", "nothing to do, or save the scene again",
        )  # fmt: skip


def _node(index: int, node: NodeAsset) -> dict[str, Any]:
    try:
        return _NODE.write(node)
    except Bad as bad:
        raise bad.under(f"nodes[{index}]") from None


def _dumps(value: Any, place: Place) -> str:
    try:
        return json.dumps(value, sort_keys=True, ensure_ascii=False, allow_nan=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise FormatError(f"cannot be written: {error}", where=place) from error
