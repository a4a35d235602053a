"""EXT_mesh_gpu_instancing: one mesh at many places becomes as many nodes below the node that says so.

Source: EXT_mesh_gpu_instancing (Khronos, 2022). Other instance attributes are named in a finding.
"""

from __future__ import annotations

import copy

import numpy as np
from numpy.typing import NDArray

from engine.assets.scene import NodeAsset
from importers.gltf.accessors import Accessors
from importers.gltf.document import Document

NAME = "EXT_mesh_gpu_instancing"
_WIDTHS = {"TRANSLATION": 3, "ROTATION": 4, "SCALE": 3}
#: what a node takes in memory, roughly
_NODE_BYTES = 1000


def read_instances(doc: Document, accessors: Accessors, index: int, asset: NodeAsset, row: int) -> list[NodeAsset]:
    """The instances of node `index`, children of `row`; its mesh moves into them. Empty where the node has none."""
    extension = doc.extension(doc.objects("nodes")[index], NAME, f"nodes[{index}]")
    if extension is None or asset.mesh is None:
        return []
    place = f"nodes[{index}].extensions.{NAME}.attributes"
    attributes = doc.child(extension, "attributes", place.removesuffix(".attributes"))
    columns: dict[str, NDArray[np.float64]] = {}
    for name in attributes:
        if name not in _WIDTHS:
            doc.findings.info("gltf.instances", f"the instance attribute {name[:60]!r} is not imported", place)
            continue
        number = doc.index(attributes, name, place, "accessors")
        values = None if number is None else accessors.floats(number)
        if values is None or values.shape[1] != _WIDTHS[name] or not np.isfinite(values).all():
            doc.findings.error("gltf.instances", f"{name} cannot be read; left out", f"{place}.{name}")
            continue
        columns[name] = values.astype(np.float64)
    counts = {len(values) for values in columns.values()}
    if len(counts) != 1:
        doc.findings.error(
            "gltf.instances", "the instances have no attributes" if not counts else "the attributes differ in length",
            place, "the mesh appears once",
        )  # fmt: skip
        return []
    count = counts.pop()
    if not accessors.charge(count * _NODE_BYTES, place):
        return []
    rotations = columns.get("ROTATION", np.tile([0.0, 0.0, 0.0, 1.0], (count, 1)))
    length = np.linalg.norm(rotations, axis=1, keepdims=True)
    rotations = np.where(length > 1e-12, rotations / np.where(length > 0, length, 1.0), [0.0, 0.0, 0.0, 1.0])
    rows = zip(
        columns.get("TRANSLATION", np.zeros((count, 3))).tolist(), rotations.tolist(),
        columns.get("SCALE", np.ones((count, 3))).tolist(), strict=True,
    )  # fmt: skip
    result = [
        NodeAsset(
            f"{asset.name} {k}",
            row,
            (t[0], t[1], t[2]),
            (r[0], r[1], r[2], r[3]),
            (s[0], s[1], s[2]),
            mesh=copy.deepcopy(asset.mesh),
            weights=list(asset.weights),
        )
        for k, (t, r, s) in enumerate(rows)
    ]
    doc.findings.info("gltf.instances", f"{count:,} instances become nodes", place)
    asset.mesh, asset.weights = None, []
    return result
