"""What the user corrects of a source as it is read: its size, which way is up, its uvs, normals, tangents, faces.

Sizes are changed in the data (positions, offsets, places, bind poses, keys), turns at the tops of the tree (places and
keys), so that no node with a scale of 0.01 is left for others to wonder about. All by settings that a sidecar keeps.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import Channel
from engine.assets.mesh import MeshAsset, MorphTarget, Submesh
from engine.assets.scene import NodeAsset
from engine.math import quat
from importers.geometry.added_tangents import add_tangents
from importers.geometry.crease import crease_normals
from importers.geometry.normals import flat_normals
from importers.geometry.quantize import snorm16_vectors
from importers.model import ImportedModel
from importers.settings import ImportSettings

#: setting -> (axis, angle): the turn that makes it so
TURNS: dict[str, tuple[tuple[float, float, float], float]] = {
    "z-up": ((1.0, 0.0, 0.0), -math.pi / 2),
    "z-down": ((1.0, 0.0, 0.0), math.pi / 2),
    "x-up": ((0.0, 0.0, 1.0), math.pi / 2),
    "y-down": ((1.0, 0.0, 0.0), math.pi),
    "back": ((0.0, 1.0, 0.0), math.pi),
    "left": ((0.0, 1.0, 0.0), math.pi / 2),
    "right": ((0.0, 1.0, 0.0), -math.pi / 2),
}
#: two faces that meet at less are smooth over their edge, radians
SMOOTH = math.radians(60.0)


def wanted(settings: ImportSettings) -> bool:
    """Whether any of it is asked for."""
    return (
        settings.scale != 1.0 or settings.turn != "none" or settings.flip_v or settings.two_sided
        or settings.normals != "keep" or settings.tangents
    )  # fmt: skip


def adjust(model: ImportedModel, settings: ImportSettings) -> None:
    """Change `model` in place as the settings say; what cannot be done is a finding."""
    if settings.scale != 1.0:
        _scale(model, settings.scale)
    if settings.turn != "none":
        axis, angle = TURNS[settings.turn]
        _turn(model, quat.from_axis_angle(np.array(axis), angle))
    if settings.two_sided:
        for material in model.materials:
            if "double_sided" not in material.asset.features:
                material.asset.features.append("double_sided")
    for mesh in model.meshes:
        where = f"meshes[{mesh.name}]"
        if settings.flip_v:
            for name in ("uv0", "uv1"):
                if name in mesh.streams:
                    uv = np.array(mesh.streams[name], np.float32)
                    uv[:, 1] = np.float32(1.0) - uv[:, 1]
                    mesh.streams[name] = uv
            if "tangent" in mesh.streams:
                tangent = np.array(mesh.streams["tangent"])
                tangent[:, 3] = -tangent[:, 3]  # the bitangent follows v
                mesh.streams["tangent"] = tangent
        if settings.normals != "keep" and not _new_normals(mesh, smooth=settings.normals == "smooth"):
            model.findings.warn("mesh.normals", "has lines, points or morphed normals; they stay as they are", where)
        if settings.tangents:
            mesh.streams.pop("tangent", None)
            if not add_tangents(mesh):
                model.findings.warn("mesh.tangents", "has no uvs to make tangents from", where)


def _scale(model: ImportedModel, factor: float) -> None:
    for mesh in model.meshes:
        mesh.streams["position"] = _times(mesh.streams["position"], factor)
        mesh.morphs = [
            MorphTarget(m.name, {n: _times(v, factor) if n == "position" else v for n, v in m.streams.items()})
            for m in mesh.morphs
        ]
        if mesh.skeleton is not None:
            bind = np.array(mesh.skeleton.inverse_bind, np.float64)
            bind[:, :3, 3] *= factor
            mesh.skeleton.inverse_bind = bind.astype(np.float32)
        mesh.submeshes = [
            Submesh(
                s.first_index, s.index_count, s.material_slot, s.topology, _triple(s.bounds_min, factor),
                _triple(s.bounds_max, factor),
            )
            for s in mesh.submeshes
        ]  # fmt: skip
    for node in model.nodes:
        node.translation = _triple(node.translation, factor)
        if node.matrix is not None:  # by columns: the last one is the place
            node.matrix = (*node.matrix[:12], *(v * factor for v in node.matrix[12:15]), node.matrix[15])
        stood = node.extras.get("skin_bind_world")
        if isinstance(stood, (list, tuple)) and len(stood) == 16:
            node.extras["skin_bind_world"] = [v * factor if i in (12, 13, 14) else v for i, v in enumerate(stood)]
        if node.camera is not None:
            node.camera.ymag *= factor
            node.camera.znear *= factor
            node.camera.zfar *= factor
        if node.light is not None:
            node.light.range *= factor
            node.light.width *= factor
            node.light.height *= factor
            if node.light.type in ("point", "spot"):
                node.light.intensity *= factor * factor  # as bright on what is that much farther away
    for clip in model.clips:
        clip.channels = [_keys(c, _times(c.values, factor)) if c.path == "translation" else c for c in clip.channels]


def _turn(model: ImportedModel, turn: NDArray[np.float64]) -> None:
    """Turn everything about the origin: the tops of the tree, and the keys that move them."""
    matrix = np.eye(4)
    matrix[:3, :3] = quat.to_matrix3(turn)
    tops = {i for i, node in enumerate(model.nodes) if node.parent < 0}
    for index in tops:
        _turn_node(model.nodes[index], turn, matrix)
    for node in model.nodes:
        bind = node.extras.get("skin_bind_world")
        if isinstance(bind, (list, tuple)) and len(bind) == 16:
            turned = matrix @ np.array(bind, np.float64).reshape(4, 4).T
            node.extras["skin_bind_world"] = turned.T.reshape(16).tolist()
    for clip in model.clips:
        channels = []
        for channel in clip.channels:
            if channel.node in tops and channel.path == "translation":
                values = np.asarray(channel.values, np.float64) @ matrix[:3, :3].T
                channel = _keys(channel, values.astype(np.float32))
            elif channel.node in tops and channel.path == "rotation":
                values = quat.multiply(turn, np.asarray(channel.values, np.float64))
                channel = _keys(channel, values.astype(np.float32))
            channels.append(channel)
        clip.channels = channels


def _turn_node(node: NodeAsset, turn: NDArray[np.float64], matrix: NDArray[np.float64]) -> None:
    x, y, z = (matrix[:3, :3] @ np.array(node.translation)).tolist()
    qx, qy, qz, qw = quat.normalize(quat.multiply(turn, np.array(node.rotation))).tolist()
    node.translation, node.rotation = (x, y, z), (qx, qy, qz, qw)
    if node.matrix is not None:
        node.matrix = tuple((matrix @ np.array(node.matrix).reshape(4, 4).T).T.reshape(16).tolist())


def _new_normals(mesh: MeshAsset, *, smooth: bool) -> bool:
    """False, and nothing changed, where it cannot be done."""
    if any(part.topology != "triangles" for part in mesh.submeshes) or any("normal" in m.streams for m in mesh.morphs):
        return False
    position = np.asarray(mesh.streams["position"], np.float32)
    triangles = mesh.indices.reshape(-1, 3)
    if smooth:
        _, point = np.unique(position, axis=0, return_inverse=True)
        corners = crease_normals(position[triangles].astype(np.float64), point.reshape(-1)[triangles], SMOOTH)
        rows = np.round(corners.reshape(-1, 3), 6)
        keys = np.column_stack([mesh.indices.astype(np.float64), rows])
        _, first, number = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        source = mesh.indices[first].astype(np.int64)
        normals, indices = rows[first].astype(np.float32), number.reshape(-1).astype("<u4")
    else:
        source, normals, made = flat_normals(position, triangles)
        indices = made.reshape(-1).astype("<u4")
    had_tangents = "tangent" in mesh.streams
    mesh.streams = {name: np.ascontiguousarray(values[source]) for name, values in mesh.streams.items()}
    mesh.streams["normal"] = snorm16_vectors(normals)
    mesh.streams.pop("tangent", None)
    mesh.indices = np.ascontiguousarray(indices)
    for morph in mesh.morphs:
        morph.streams = {name: np.ascontiguousarray(values[source]) for name, values in morph.streams.items()}
    if had_tangents:
        add_tangents(mesh)
    return True


def _keys(channel: Channel, values: NDArray[np.float32]) -> Channel:
    return Channel(channel.node, channel.path, channel.interpolation, channel.times, values, channel.target)


def _times(values: NDArray[np.generic], factor: float) -> NDArray[np.float32]:
    return (np.asarray(values, np.float64) * factor).astype(np.float32)


def _triple(values: tuple[float, float, float], factor: float) -> tuple[float, float, float]:
    return values[0] * factor, values[1] * factor, values[2] * factor
