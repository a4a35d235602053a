"""Extras: what a file's author wrote beside the standard. Kept as they are, and written out again by export.

What the engine itself reads from extras stands under the key `lucarna`, checked here, so that no stranger's key of the
same name changes a picture:

    nodes[i].extras.lucarna   skin_bind_world            meshes[i].extras.lucarna   skinning, dual_quaternion_share
    animations[i].extras.lucarna   start, frame_rate     scenes[i].extras.lucarna   see surroundings.py
"""

from __future__ import annotations

import math
from typing import Any

from importers.gltf.document import Document, JsonObject
from importers.gltf.uris import storable_text

OWN = "lucarna"
NODE_KEYS = ("skin_bind_world",)
MESH_KEYS = ("skinning", "dual_quaternion_share")
CLIP_KEYS = ("start", "frame_rate")


def read_extras(doc: Document, owner: JsonObject, where: str, keys: tuple[str, ...]) -> dict[str, object]:
    """The extras of an object, without its own part; of that, the sound values of `keys` at top level."""
    extras = owner.get("extras")
    if not isinstance(extras, dict):
        return {}
    own = extras.get(OWN)
    kept = {k: v for k, v in extras.items() if k not in keys and k not in (OWN, "targetNames")}
    result: dict[str, object] = storable(kept)
    if not isinstance(own, dict):
        return result
    for key in keys:
        if key not in own:
            continue
        if _sound(own[key]):
            result[key] = own[key]
        else:
            doc.findings.warn("gltf.extras", f"{key} holds no numbers; ignored", f"{where}.extras.{OWN}.{key}")
    return result


def split_extras(extras: dict[str, object], keys: tuple[str, ...]) -> dict[str, Any]:
    """The other way: what to write as an object's extras, the engine's keys under their own name; {} for nothing."""
    own = {k: extras[k] for k in keys if k in extras}
    plain: dict[str, Any] = {k: v for k, v in extras.items() if k not in keys}
    return plain | ({OWN: own} if own else {})


def _sound(value: Any) -> bool:
    if isinstance(value, str):
        return len(value) < 100
    values = value if isinstance(value, list) else [value]
    return all(isinstance(v, (int, float)) and not isinstance(v, bool) and math.isfinite(v) for v in values)


def storable(value: Any) -> Any:
    """Any JSON as TOML can hold it: numbers that are not finite or beyond 64 bits, and nulls, are left out.

    Recursion is safe: the container bounds the depth."""
    if isinstance(value, dict):
        items = {storable_text(k): storable(v) for k, v in value.items()}
        return {k: v for k, v in items.items() if v is not None}
    if isinstance(value, list):
        return [v for v in map(storable, value) if v is not None]
    if isinstance(value, str):
        return storable_text(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        return None
    return value
