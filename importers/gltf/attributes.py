"""Vertex attributes of one primitive: read, checked, and mended where a value makes no sense.

Source: glTF 2.0 specification (Khronos, 2021), section 3.7.2.1 (attribute types).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from importers.geometry.normals import unit
from importers.gltf.accessors import Accessors
from importers.gltf.document import Document

Floats = NDArray[np.float32]

#: attribute -> numbers of components allowed
_COMPONENTS = {"POSITION": (3,), "NORMAL": (3,), "TANGENT": (4,), "TEXCOORD": (2,), "COLOR": (3, 4),
               "JOINTS": (4,), "WEIGHTS": (4,)}  # fmt: skip
_SETS = {"TEXCOORD": 2, "COLOR": 1, "JOINTS": 4, "WEIGHTS": 4}
_SEMANTIC = re.compile(r"([A-Z]+)(?:_(\d+))?$")


@dataclass(slots=True)
class VertexData:
    """Plain arrays of n vertices; `broken` marks vertices whose position is no number: nothing may use them."""

    position: Floats
    broken: NDArray[np.bool_]
    normal: Floats | None = None
    tangent: Floats | None = None
    uv: dict[int, Floats] = field(default_factory=dict)
    color: Floats | None = None
    joints: NDArray[np.int64] | None = None
    weights: NDArray[np.float64] | None = None

    def gather(self, source: NDArray[np.int64]) -> VertexData:
        """The vertices `source`, in that order."""

        def take(a: Any) -> Any:
            return None if a is None else a[source]

        return VertexData(
            self.position[source], self.broken[source], take(self.normal), take(self.tangent),
            {k: v[source] for k, v in self.uv.items()}, take(self.color), take(self.joints), take(self.weights),
        )  # fmt: skip


def read_vertices(doc: Document, accessors: Accessors, attributes: dict[str, Any], where: str) -> VertexData | None:
    """The vertices of a primitive; None (with a finding) where there are no positions to be had."""
    findings = doc.findings
    if "POSITION" not in attributes:
        findings.error("gltf.no-positions", "the primitive has no POSITION, so nothing to draw", where)
        return None
    position = _floats(doc, accessors, attributes, "POSITION", where, None)
    if position is None:
        return None
    count = len(position)
    # Squared lengths must still fit float32
    broken = np.asarray(~(np.abs(position) < 1e18).all(axis=1))
    if broken.any():
        first = int(np.argmax(broken))
        findings.error(
            "gltf.not-finite",
            f"{int(broken.sum()):,} of {count:,} positions are no usable numbers (first: vertex {first}); "
            "what they belong to is left out", f"{where}.POSITION", "export the mesh again",
        )  # fmt: skip
        position = np.where(broken[:, None], np.float32(0), position)
    data = VertexData(position, broken)
    for name in attributes:
        match = _SEMANTIC.match(name)
        semantic, number = (match[1], int(match[2] or 0)) if match else (name, 0)
        if semantic not in _COMPONENTS or number >= _SETS.get(semantic, 1):
            findings.info("gltf.attribute", f"the attribute {name[:60]!r} is not imported", where)
    data.normal = _directions(doc, accessors, attributes, "NORMAL", where, count)
    tangent = _directions(doc, accessors, attributes, "TANGENT", where, count)
    if tangent is not None and data.normal is not None:
        signs = tangent[:, 3]
        if not (np.abs(signs) == 1).all():
            findings.warn("gltf.tangent-sign", "some tangents' w is neither 1 nor -1; made so", f"{where}.TANGENT")
            tangent = tangent.copy()
            tangent[:, 3] = np.where(signs < 0, -1, 1)
        data.tangent = tangent
    for number in range(_SETS["TEXCOORD"]):
        uv = _floats(doc, accessors, attributes, f"TEXCOORD_{number}", where, count)
        if uv is not None:
            data.uv[number] = _zero_broken(doc, uv, f"{where}.TEXCOORD_{number}")
    data.color = _color(doc, accessors, attributes, where, count)
    _influences(doc, accessors, attributes, where, data)
    return data


def _floats(
    doc: Document, accessors: Accessors, attributes: dict[str, Any], name: str, where: str, count: int | None
) -> Floats | None:
    if name not in attributes:
        return None
    place = f"{where}.{name}"
    index = doc.index(attributes, name, where, "accessors")
    if index is None:
        return None
    values = accessors.floats(index)
    if values is None:
        doc.findings.error("gltf.attribute", f"accessors[{index}] cannot be read, so the mesh lacks {name}", place)
        return None
    expected = _COMPONENTS[name.split("_", 1)[0]]
    if values.shape[1] not in expected:
        doc.findings.error("gltf.type", f"{values.shape[1]} components, expected {expected[-1]}; left out", place)
        return None
    if count is not None and len(values) != count:
        doc.findings.error(
            "gltf.count", f"{len(values):,} values for {count:,} positions; left out", place, "export the mesh again"
        )
        return None
    return values


def _directions(
    doc: Document, accessors: Accessors, attributes: dict[str, Any], name: str, where: str, count: int
) -> Floats | None:
    """Normals or tangents of length 1; rows that have no direction are all zero (the caller fills them)."""
    values = _floats(doc, accessors, attributes, name, where, count)
    if values is None:
        return None
    xyz = values[:, :3].astype(np.float64)
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.sqrt((xyz * xyz).sum(axis=1))
    bad = ~np.isfinite(length) | (length < 1e-6)
    off = ~bad & (np.abs(length - 1) > 0.02)
    if bad.any():
        doc.findings.warn(
            f"gltf.{name.lower()}s",
            f"{int(bad.sum()):,} of {count:,} have no direction (zero or no number); made anew", f"{where}.{name}",
        )  # fmt: skip
    if off.any():
        doc.findings.info(
            f"gltf.{name.lower()}s", f"{int(off.sum()):,} of {count:,} are not of length 1; normalised",
            f"{where}.{name}",
        )  # fmt: skip
    result = values.astype(np.float32, copy=True)
    # within what 16 bits can tell from 1 they stay: vectors written out and read again are the same
    askew = bad | ~(np.abs(length - 1) < 4e-5)
    result[askew, :3] = unit(np.where(bad[askew, None], 0.0, xyz[askew]), (0.0, 0.0, 0.0))
    return result


def _color(doc: Document, accessors: Accessors, attributes: dict[str, Any], where: str, count: int) -> Floats | None:
    values = _floats(doc, accessors, attributes, "COLOR_0", where, count)
    if values is None:
        return None
    raw = accessors.raw(attributes["COLOR_0"])
    place = f"{where}.COLOR_0"
    if raw is not None and raw.dtype.kind in "iu" and not accessors.is_normalized(attributes["COLOR_0"]):
        doc.findings.warn("gltf.color", "integer colours without `normalized`; read as normalised", place)
        values = values / np.float32(np.iinfo(raw.dtype).max)
    values = _zero_broken(doc, values, place)
    if (values < 0).any() or (values > 1).any():
        doc.findings.warn("gltf.color", "colours outside 0..1 are clamped", place)
    if values.shape[1] == 3:
        values = np.concatenate([values, np.ones((count, 1), np.float32)], axis=1)
    return values


def _influences(doc: Document, accessors: Accessors, attributes: dict[str, Any], where: str, data: VertexData) -> None:
    count = len(data.position)
    all_joints, all_weights = [], []
    for number in range(_SETS["JOINTS"]):
        names = f"JOINTS_{number}", f"WEIGHTS_{number}"
        if not any(name in attributes for name in names):
            continue
        joints = _floats(doc, accessors, attributes, names[0], where, count)
        weights = _floats(doc, accessors, attributes, names[1], where, count)
        if joints is None or weights is None:
            doc.findings.error("gltf.skin", f"{names[0]} and {names[1]} are not both there; left out", where)
            continue
        raw = accessors.raw(attributes[names[0]])
        if raw is None or raw.dtype.kind != "u":
            doc.findings.error("gltf.skin", "joints must be unsigned bytes or shorts; left out", f"{where}.{names[0]}")
            continue
        all_joints.append(raw.astype(np.int64))
        all_weights.append(weights.astype(np.float64))
    if all_joints:
        data.joints = np.concatenate(all_joints, axis=1)
        data.weights = np.concatenate(all_weights, axis=1)


def _zero_broken(doc: Document, values: Floats, place: str) -> Floats:
    finite = np.isfinite(values)
    if finite.all():
        return values
    count = int((~finite).any(axis=1).sum())
    doc.findings.error("gltf.not-finite", f"{count:,} of {len(values):,} values are no numbers; taken as 0", place)
    return np.where(finite, values, np.float32(0))
