"""A glTF source of one crate, 1 x 1 x 2 m along z: small enough to import in a moment, real enough to come again."""

from __future__ import annotations

import base64
import json
from pathlib import Path

import numpy as np
from small_scene import box

from engine.assets.mesh import MeshAsset


def write_small_source(path: Path, mesh: MeshAsset | None = None) -> Path:
    """Write `path` (.gltf, its buffer inside) with the node `crate` and the material `wood`."""
    mesh = mesh or box()
    position = np.asarray(mesh.streams["position"], np.float32) * np.array([1, 1, 2], np.float32)
    normal = (np.asarray(mesh.streams["normal"][:, :3], np.float32) / 32767).astype(np.float32)
    parts = [position.tobytes(), normal.tobytes(), mesh.indices.astype("<u4").tobytes()]
    starts = np.cumsum([0, *(len(p) for p in parts)]).tolist()
    count = len(position)
    data = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "crate", "mesh": 0}],
        "materials": [
            {
                "name": "wood",
                "pbrMetallicRoughness": {
                    "baseColorFactor": [0.5, 0.25, 0.1, 1], "metallicFactor": 0, "roughnessFactor": 0.6,
                },
            }
        ],
        "meshes": [
            {"name": "crate", "primitives": [{"attributes": {"POSITION": 0, "NORMAL": 1}, "indices": 2, "material": 0}]}
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3",
             "min": position.min(axis=0).tolist(), "max": position.max(axis=0).tolist()},
            {"bufferView": 1, "componentType": 5126, "count": count, "type": "VEC3"},
            {"bufferView": 2, "componentType": 5125, "count": len(mesh.indices), "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(part)}
            for start, part in zip(starts, parts, strict=False)
        ],
        "buffers": [
            {"byteLength": starts[-1],
             "uri": "data:application/octet-stream;base64," + base64.b64encode(b"".join(parts)).decode()}
        ],
    }  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(data))
    return path
