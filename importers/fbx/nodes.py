"""Nodes, lights and cameras: the worker's scene as NodeAssets, without the cameras that every exporter adds.

Lights have no physical unit in FBX. Blender writes its own: irradiance for suns, radiant power for the rest. Others: a
light of intensity 1 (100 %) makes a facing white surface 1, as the classic renderers did, so it has pi lux; one without
decay is given what it needs for that at the middle of the scene.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.assets.scene import CameraAsset, LightAsset, NodeAsset
from engine.math.transform import compose
from importers.fbx.document import FbxDocument, Json

#: what the FBX SDK writes into every file
_SYSTEM_CAMERAS = {"Producer Perspective", "Producer Front", "Producer Back", "Producer Right", "Producer Left",
                   "Producer Top", "Producer Bottom", "Camera Switcher"}  # fmt: skip


def read_nodes(doc: FbxDocument) -> tuple[list[NodeAsset], dict[int, int]]:
    """The nodes in order, and the row of each of the document's nodes that is among them."""
    translation, rotation, scale = (doc.floats(doc.data[k], n) for k, n in _COLUMNS)
    world = _world_matrices(doc, translation, rotation, scale)
    middle = _middle(doc, world)
    has_children = set(doc.parents)
    rows: dict[int, int] = {}
    assets: list[NodeAsset] = []
    for index, node in enumerate(doc.nodes):
        if _is_dropped(doc, index, node, has_children):
            continue
        t, q, s = translation[index], rotation[index], scale[index]
        asset = NodeAsset(
            doc.names[index], rows.get(doc.parents[index], -1),
            (float(t[0]), float(t[1]), float(t[2])), _unit(q), (float(s[0]), float(s[1]), float(s[2])),
            visible=bool(node["visible"]),
        )  # fmt: skip
        if _is_lower_level(doc, index):
            asset.visible = False
            doc.findings.info("fbx.lod", "a lower level of detail; hidden", f"nodes[{doc.names[index]}]")
        if node["light"] >= 0:
            distance = float(np.linalg.norm(world[index, :3, 3] - middle))
            sizes = np.linalg.norm(world[index, :3, :2], axis=0)
            asset.light = _light(doc, doc.data["lights"][node["light"]], distance, index)
            _spread(doc, doc.data["lights"][node["light"]], asset.light, sizes, index)
        if node["camera"] >= 0:
            asset.camera = _camera(doc.data["cameras"][node["camera"]])
        if 0.0 in asset.scale:
            doc.findings.warn(
                "fbx.zero-scale", f"the scale {list(asset.scale)} flattens whatever hangs on the node",
                f"nodes[{doc.names[index]}]", "give it a small scale instead, or hide it",
            )  # fmt: skip
        rows[index] = len(assets)
        assets.append(asset)
    return assets, rows


_COLUMNS = (("translation", 3), ("rotation", 4), ("scale", 3))


def active_camera(doc: FbxDocument, rows: dict[int, int]) -> int:
    """The row of the camera that the file names as its own, else of its first one, else -1."""
    cameras = [i for i, node in enumerate(doc.nodes) if i in rows and node["camera"] >= 0]
    named = [i for i in cameras if doc.nodes[i]["name"] == doc.data["default_camera"]]
    return rows[(named or cameras)[0]] if cameras else -1


def _is_dropped(doc: FbxDocument, index: int, node: Json, has_children: set[int]) -> bool:
    if node["root"]:
        return True
    system = node["name"] in _SYSTEM_CAMERAS and node["kind"] in ("camera", "camera_switcher", "unknown")
    return system and index not in has_children


def _is_lower_level(doc: FbxDocument, index: int) -> bool:
    """Whether the node is one of an LOD group's, and not its first."""
    parent = doc.parents[index]
    return parent >= 0 and doc.nodes[parent]["kind"] == "lod_group" and parent in doc.parents[:index]


def _unit(q: NDArray[np.float64]) -> tuple[float, float, float, float]:
    length = float(np.linalg.norm(q))
    if length < 1e-12:
        return (0.0, 0.0, 0.0, 1.0)
    x, y, z, w = (q / length).tolist()
    return (x, y, z, w)


def _world_matrices(
    doc: FbxDocument, translation: NDArray[np.float64], rotation: NDArray[np.float64], scale: NDArray[np.float64]
) -> NDArray[np.float64]:
    world = compose(translation, rotation, scale)
    with np.errstate(over="ignore", invalid="ignore"):
        for index, parent in enumerate(doc.parents):
            if parent >= 0:
                world[index] = world[parent] @ world[index]
    return np.nan_to_num(world, nan=0.0, posinf=0.0, neginf=0.0)


def _middle(doc: FbxDocument, world: NDArray[np.float64]) -> NDArray[np.float64]:
    """The mean of the centres of all drawn meshes, in world space."""
    centres = []
    for index, node in enumerate(doc.nodes):
        if node["mesh"] >= 0:
            points = doc.floats(doc.meshes[node["mesh"]]["positions"], 3)
            if len(points):
                centre = (points.min(axis=0) + points.max(axis=0)) / 2
                centres.append(world[index, :3, :3] @ centre + world[index, :3, 3])
    return np.mean(centres, axis=0) if centres else np.zeros(3)


def _spread(doc: FbxDocument, light: Json, asset: LightAsset, sizes: NDArray[np.float64], index: int) -> None:
    """Make a point light that the file says is a rectangle one: two units wide and high, times its node's scale."""
    width, height = (2.0 * float(v) for v in sizes)
    if light["type"] != "area" or light.get("shape") != "rectangle" or not width * height > 0.0:
        return
    if str(doc.data["application"]).startswith("Blender"):
        asset.intensity *= 4.0  # the same power from one side, by the cosine: power over pi straight ahead
    asset.type, asset.width, asset.height = "rectangle", width, height
    asset.intensity /= width * height
    doc.findings.info(
        "fbx.light", f"a rectangle light of {width:.3g} by {height:.3g} m, by its node's scale",
        f"nodes[{doc.names[index]}].light", "set its size if the file's program means another",
    )  # fmt: skip


def _light(doc: FbxDocument, light: Json, distance: float, index: int) -> LightAsset:
    where = f"nodes[{doc.names[index]}].light"
    kind = str(light["type"])
    if kind == "volume" or (kind == "area" and light.get("shape") != "rectangle"):
        doc.findings.info("fbx.light", f"a light of kind {kind} is imported as a point light", where)
    asset = LightAsset({"directional": "directional", "spot": "spot"}.get(kind, "point"))
    asset.casts_shadow = asset.type != "directional" and bool(light.get("shadows", True))
    r, g, b = (max(float(v), 0.0) for v in light["color"])
    asset.color = (r, g, b)
    strength = max(float(light["intensity"]), 0.0) if light["on"] else 0.0
    asset.intensity = math.pi * strength
    if str(doc.data["application"]).startswith("Blender"):
        # power spread over the whole sphere
        asset.intensity = strength if asset.type == "directional" else strength / (4 * math.pi)
    elif asset.type != "directional":
        if light["decay"] == "quadratic":
            asset.intensity *= float(doc.data["unit_meters"]) ** 2
        else:
            asset.intensity *= max(distance, 1e-3) ** 2
            doc.findings.info(
                "fbx.light", f"a light with decay {light['decay']!r}: its strength fits the middle of the scene only",
                where, "set the decay to quadratic",
            )  # fmt: skip
    if asset.type == "spot":
        outer = math.radians(float(light["outer_angle"])) / 2
        asset.outer_angle = min(max(outer, 1e-3), math.pi / 2)
        inner = math.radians(float(light["inner_angle"])) / 2
        asset.inner_angle = min(max(inner, 0.0), asset.outer_angle * 0.99)
    return asset


def _camera(camera: Json) -> CameraAsset:
    aspect = max(float(camera["aspect"]), 0.0)
    asset = CameraAsset("orthographic" if camera["orthographic"] else "perspective", aspect=min(aspect, 1e4))
    near, far = float(camera["near"]), float(camera["far"])
    asset.znear = near if 0 < near < 1e9 else asset.znear
    asset.zfar = far if asset.znear < far < 3e38 else 0.0
    if camera["orthographic"]:
        asset.ymag = max(float(camera["size"][1]) / 2, 1e-6)
    else:
        asset.yfov = min(max(math.radians(float(camera["fov_deg"][1])), 1e-3), math.pi - 1e-3)
    return asset
