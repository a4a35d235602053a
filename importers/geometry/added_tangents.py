"""Tangents for a finished mesh: where a normal map is found only after the mesh was read."""

from __future__ import annotations

import numpy as np

from engine.assets.mesh import STREAMS, MeshAsset
from importers.geometry.quantize import snorm16_vectors
from importers.geometry.tangents import tangent_frames


def add_tangents(mesh: MeshAsset, uv: str = "uv0") -> bool:
    """Add the tangent stream where it is missing; vertices are split where frames differ.

    False, and nothing changed, where the mesh has no such coordinates, or lines or points among its parts."""
    if "tangent" in mesh.streams:
        return True
    if uv not in mesh.streams or any(part.topology != "triangles" for part in mesh.submeshes):
        return False
    normals = np.asarray(mesh.streams["normal"][:, :3], np.float32) / np.float32(32767.0)
    source, tangents, triangles = tangent_frames(
        np.asarray(mesh.streams["position"], np.float32), normals, np.asarray(mesh.streams[uv], np.float32),
        mesh.indices.reshape(-1, 3),
    )  # fmt: skip
    streams = {name: values[source] for name, values in mesh.streams.items()}
    streams["tangent"] = snorm16_vectors(tangents[:, :3], tangents[:, 3])
    mesh.streams = {name: streams[name] for name in STREAMS if name in streams}
    mesh.indices = np.ascontiguousarray(triangles.reshape(-1), "<u4")
    for morph in mesh.morphs:
        morph.streams = {name: values[source] for name, values in morph.streams.items()}
    return True
