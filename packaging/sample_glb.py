"""A small writer of binary glTF 2.0, as much as the sample scene needs. Same calls, same bytes.

Glb: textures, materials, meshes, nodes, animation channels -> glb() -> bytes
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sample_shapes import Mesh

_COMPONENTS = {np.dtype("<f4"): 5126, np.dtype("<u2"): 5123, np.dtype("<u4"): 5125, np.dtype("u1"): 5121}
_SHAPES = {(): "SCALAR", (2,): "VEC2", (3,): "VEC3", (4,): "VEC4"}
_VERTICES, _INDICES = 34962, 34963


@dataclass(slots=True)
class Glb:
    """Collects a document. All `add_*` return the index that glTF uses."""

    generator: str
    copyright: str
    document: dict[str, list[Any]] = field(default_factory=dict)
    extensions: set[str] = field(default_factory=set)
    lights: list[dict[str, Any]] = field(default_factory=list)
    _blob: bytearray = field(default_factory=bytearray)
    _accessors: dict[tuple[object, ...], int] = field(default_factory=dict)

    def _append(self, kind: str, value: dict[str, Any]) -> int:
        items = self.document.setdefault(kind, [])
        items.append(value)
        return len(items) - 1

    def _view(self, data: bytes, target: int = 0) -> int:
        self._blob += b"\0" * (-len(self._blob) % 4)
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self._blob), "byteLength": len(data)}
        if target:
            view["target"] = target
        self._blob += data
        return self._append("bufferViews", view)

    def add_accessor(
        self, values: NDArray[Any], target: int = 0, *, bounds: bool = False, normalized: bool = False
    ) -> int:
        """`values` [n] or [n,k] in one of the component types, tightly packed. Equal data is stored once."""
        key = (values.tobytes(), values.dtype, values.shape, target, bounds, normalized)
        if key in self._accessors:
            return self._accessors[key]
        accessor: dict[str, Any] = {
            "bufferView": self._view(np.ascontiguousarray(values).tobytes(), target),
            "componentType": _COMPONENTS[values.dtype],
            "count": len(values),
            "type": _SHAPES[values.shape[1:]],
        }
        if normalized:
            accessor["normalized"] = True
        if bounds:
            accessor["min"] = np.atleast_1d(values.min(0)).tolist()
            accessor["max"] = np.atleast_1d(values.max(0)).tolist()
        self._accessors[key] = self._append("accessors", accessor)
        return self._accessors[key]

    def add_texture(self, name: str, data: bytes) -> int:
        mime = "image/png" if data.startswith(b"\x89PNG") else "image/jpeg"
        image = self._append("images", {"name": name, "mimeType": mime, "bufferView": self._view(data)})
        if "samplers" not in self.document:
            self._append("samplers", {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497})
        return self._append("textures", {"name": name, "source": image, "sampler": 0})

    def add_material(self, name: str, **values: Any) -> int:
        self.extensions.update(values.get("extensions", {}))
        return self._append("materials", {"name": name, **values})

    def add_mesh(self, name: str, parts: Sequence[tuple[Mesh, int]]) -> int:
        """One primitive per (mesh, material). Tangents are written where the material has a normal map."""
        primitives = []
        for mesh, material in parts:
            f4 = np.dtype("<f4")
            attributes = {
                "POSITION": self.add_accessor(mesh.positions.astype(f4), _VERTICES, bounds=True),
                "NORMAL": self.add_accessor(mesh.normals.astype(f4), _VERTICES),
                "TEXCOORD_0": self.add_accessor(mesh.uvs.astype(f4), _VERTICES),
            }
            if "normalTexture" in self.document["materials"][material]:
                attributes["TANGENT"] = self.add_accessor(mesh.tangents().astype(f4), _VERTICES)
            if mesh.uvs1 is not None:
                attributes["TEXCOORD_1"] = self.add_accessor(mesh.uvs1.astype(f4), _VERTICES)
            if mesh.colors is not None:
                colors = np.round(np.clip(mesh.colors, 0, 1) * 255).astype(np.uint8)
                attributes["COLOR_0"] = self.add_accessor(colors, _VERTICES, normalized=True)
            count = len(mesh.positions)
            indices = mesh.triangles.reshape(-1).astype("<u2" if count < 65535 else "<u4")
            primitives.append(
                {"attributes": attributes, "indices": self.add_accessor(indices, _INDICES), "material": material}
            )
        return self._append("meshes", {"name": name, "primitives": primitives})

    def add_node(self, name: str, parent: int = -1, **values: Any) -> int:
        node = self._append("nodes", {"name": name, **values})
        if parent >= 0:
            self.document["nodes"][parent].setdefault("children", []).append(node)
        return node

    def add_light(self, **values: Any) -> dict[str, Any]:
        """A light; returns the `extensions` value of the node that carries it."""
        self.extensions.add("KHR_lights_punctual")
        self.lights.append(values)
        return {"KHR_lights_punctual": {"light": len(self.lights) - 1}}

    def add_animation(self, name: str, channels: Sequence[tuple[int, str, NDArray[Any], NDArray[Any]]]) -> int:
        """`channels`: node, path (translation | rotation | scale), times [n] s, values [n,k]; linear."""
        samplers, targets = [], []
        for node, path, times, values in channels:
            line = self.add_accessor(times.astype("<f4"), bounds=True)
            output = self.add_accessor(values.astype("<f4"))
            samplers.append({"input": line, "output": output, "interpolation": "LINEAR"})
            targets.append({"sampler": len(samplers) - 1, "target": {"node": node, "path": path}})
        return self._append("animations", {"name": name, "samplers": samplers, "channels": targets})

    def to_bytes(self, *, scene_name: str, extras: Mapping[str, Any] | None = None) -> bytes:
        """The whole file; every node without a parent is a root of its one scene."""
        nodes = self.document.get("nodes", [])
        children = {child for node in nodes for child in node.get("children", [])}
        scene: dict[str, Any] = {"name": scene_name, "nodes": [i for i in range(len(nodes)) if i not in children]}
        if extras:
            scene["extras"] = dict(extras)
        root: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": self.generator, "copyright": self.copyright},
            "scene": 0,
            "scenes": [scene],
            **self.document,
            "buffers": [{"byteLength": len(self._blob)}],
        }
        if self.lights:
            root["extensions"] = {"KHR_lights_punctual": {"lights": self.lights}}
        if self.extensions:
            root["extensionsUsed"] = sorted(self.extensions)
        text = json.dumps(root, separators=(",", ":"), ensure_ascii=False).encode("utf-8")
        text += b" " * (-len(text) % 4)
        blob = bytes(self._blob) + b"\0" * (-len(self._blob) % 4)
        total = 12 + 8 + len(text) + 8 + len(blob)
        return b"".join(
            [
                struct.pack("<4sII", b"glTF", 2, total),
                struct.pack("<I4s", len(text), b"JSON"),
                text,
                struct.pack("<I4s", len(blob), b"BIN\0"),
                blob,
            ]
        )
