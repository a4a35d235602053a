"""Nodes with what hangs on them: transforms, cameras, lights.

Source: glTF 2.0 specification (Khronos, 2021), sections 3.5 and 3.10; KHR_lights_punctual (Khronos, 2018).
"""

from __future__ import annotations

import math

import numpy as np

from engine.assets.scene import IDENTITY_ROTATION, CameraAsset, LightAsset, NodeAsset
from engine.core.findings import Severity
from engine.math.transform import compose, decompose
from importers.gltf.document import Document, JsonObject
from importers.gltf.extras import NODE_KEYS, read_extras
from importers.gltf.light_profiles import PROFILES, profiled_light

_IDENTITY_MATRIX = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def node_name(doc: Document, index: int) -> str:
    return doc.name(doc.objects("nodes")[index], f"nodes[{index}]", f"node_{index}")


#: a node given by a matrix, which `apply_matrices` fills in: json path, column-major values, node
PendingMatrix = tuple[str, tuple[float, ...], NodeAsset]


def read_node(doc: Document, index: int, pending: list[PendingMatrix]) -> NodeAsset:
    """Node `index` with its TRS, camera and light; parent, mesh and joints are the caller's.

    A matrix is appended to `pending` instead: they are decomposed all at once."""
    node, where = doc.objects("nodes")[index], f"nodes[{index}]"
    asset = NodeAsset(node_name(doc, index))
    if "matrix" in node:
        if any(key in node for key in ("translation", "rotation", "scale")):
            doc.findings.warn("gltf.transform", "has both a matrix and TRS; the matrix counts", where)
        pending.append((f"{where}.matrix", doc.vector(node, "matrix", where, _IDENTITY_MATRIX), asset))
    else:
        _trs(doc, node, where, asset)
    camera = doc.index(node, "camera", where, "cameras")
    if camera is not None:
        asset.camera = read_camera(doc, camera)
    light = doc.extension(node, "KHR_lights_punctual", where)
    if light is not None:
        asset.light = _light(doc, light, where)
    profiled = doc.extension(node, PROFILES, where)
    if profiled is not None:
        asset.light = profiled_light(doc, profiled, where)
    visibility = doc.extension(node, "KHR_node_visibility", where)
    if visibility is not None and "visible" in visibility:
        asset.visible = doc.flag(visibility, "visible", f"{where}.extensions.KHR_node_visibility")
    asset.extras = read_extras(doc, node, where, NODE_KEYS)
    return asset


def _trs(doc: Document, node: JsonObject, where: str, asset: NodeAsset) -> None:
    t = doc.vector(node, "translation", where, (0.0, 0.0, 0.0))
    r = doc.vector(node, "rotation", where, IDENTITY_ROTATION)
    s = doc.vector(node, "scale", where, (1.0, 1.0, 1.0))
    length = math.sqrt(sum((v / 1e38) ** 2 for v in r)) * 1e38 if max(map(abs, r)) > 1e18 else math.hypot(*r)
    if length < 1e-12:
        doc.findings.error("gltf.rotation", "a quaternion of zeros is no rotation; taken as none", f"{where}.rotation")
        r, length = IDENTITY_ROTATION, 1.0
    elif abs(length - 1.0) > 1e-3:
        doc.findings.warn("gltf.rotation", f"the quaternion has length {length:.4g}; normalised", f"{where}.rotation")
    if abs(length - 1.0) > 1e-14:  # what is of length 1 stays bit by bit
        r = tuple(v / length for v in r)
    if 0.0 in s:
        # a scale that a clip animates may well start at zero: that is how things are made to appear
        severity = Severity.WARNING if where in _scaled_by_clips(doc) else Severity.ERROR
        doc.findings.add(
            severity, "gltf.zero-scale", f"the scale {list(s)} flattens whatever hangs on the node", f"{where}.scale",
            "give it a small scale instead, or hide it",
        )  # fmt: skip
    asset.translation = (t[0], t[1], t[2])
    asset.rotation = (r[0], r[1], r[2], r[3])
    asset.scale = (s[0], s[1], s[2])


def _scaled_by_clips(doc: Document) -> set[str]:
    """The nodes (as `nodes[3]`) whose scale some animation sets."""
    targets = (
        channel.get("target")
        for animation in doc.objects("animations")
        for channel in animation.get("channels") or ()
        if isinstance(channel, dict)
    )
    return {f"nodes[{t.get('node')}]" for t in targets if isinstance(t, dict) and t.get("path") == "scale"}


def apply_matrices(doc: Document, pending: list[PendingMatrix]) -> None:
    """Give the nodes of `pending` their TRS, and keep the matrix where it has shear."""
    if not pending:
        return
    given = np.array([values for _, values, _ in pending], np.float64).reshape(-1, 4, 4).transpose(0, 2, 1)
    matrices = given.copy()
    matrices[:, 3] = (0, 0, 0, 1)
    bent = np.asarray((np.abs(given[:, 3] - matrices[:, 3]) > 1e-6).any(axis=1))
    largest = np.abs(matrices[:, :3, :3]).max(axis=(1, 2))
    # of the matrix without its size, so that a scale of 1e-6 is not taken for a singular one
    determinant = np.linalg.det(matrices[:, :3, :3] / np.where(largest > 0, largest, 1.0)[:, None, None])
    translations, rotations, scales = decompose(matrices)
    error = np.abs(compose(translations, rotations, scales) - matrices)[:, :3, :3].max(axis=(1, 2))
    sheared = error > 1e-5 * largest
    rows = zip(pending, translations.tolist(), rotations.tolist(), scales.tolist(), strict=True)
    for k, ((where, _, asset), t, r, s) in enumerate(rows):
        asset.translation, asset.rotation, asset.scale = (
            (t[0], t[1], t[2]),
            (r[0], r[1], r[2], r[3]),
            (s[0], s[1], s[2]),
        )
        if bent[k]:
            doc.findings.warn("gltf.matrix", "the last row is not 0 0 0 1; taken as that", where)
        if abs(determinant[k]) < 1e-12:
            doc.findings.error(
                "gltf.singular", "the matrix is singular: it flattens whatever hangs on the node", where,
                "export the transform again",
            )  # fmt: skip
        if sheared[k]:
            doc.findings.info("gltf.shear", "the matrix has shear; kept whole, beside its best fit by TRS", where)
            asset.matrix = tuple(matrices[k].T.reshape(-1).tolist())


def read_camera(doc: Document, index: int) -> CameraAsset:
    camera, where = doc.objects("cameras")[index], f"cameras[{index}]"
    kind = doc.choice(camera, "type", where, ("perspective", "orthographic"), "perspective")
    lens, place = doc.child(camera, kind, where), f"{where}.{kind}"
    asset = CameraAsset(kind)
    asset.znear = doc.number(lens, "znear", place, 0.05 if kind == "perspective" else 0.0, 0.0, 1e9)
    asset.zfar = doc.number(lens, "zfar", place, 0.0, 0.0, 3e38)
    if kind == "perspective":
        asset.yfov = doc.number(lens, "yfov", place, asset.yfov, 1e-3, math.pi - 1e-3)
        asset.aspect = doc.number(lens, "aspectRatio", place, 0.0, 0.0, 1e4)
        if asset.znear <= 0:
            doc.findings.warn("gltf.camera", "the near plane must be beyond 0; taken as 0.05", f"{place}.znear")
            asset.znear = 0.05
    else:
        xmag = abs(doc.number(lens, "xmag", place, 1.0))
        asset.ymag = abs(doc.number(lens, "ymag", place, 1.0))
        if xmag == 0 or asset.ymag == 0:
            doc.findings.error("gltf.camera", "a magnification of 0 shows nothing; taken as 1", place)
            xmag, asset.ymag = xmag or 1.0, asset.ymag or 1.0
        asset.aspect = xmag / asset.ymag
    if asset.zfar and asset.zfar <= asset.znear:
        doc.findings.error("gltf.camera", "the far plane is not beyond the near plane; taken as infinite", place)
        asset.zfar = 0.0
    return asset


def _light(doc: Document, reference: JsonObject, where: str) -> LightAsset | None:
    place = f"{where}.extensions.KHR_lights_punctual"
    holder = doc.extension(doc.root, "KHR_lights_punctual", "") or {}
    lights = doc.child_objects(holder, "lights", "extensions.KHR_lights_punctual")
    number = doc.integer(reference, "light", place)
    if number is None or not 0 <= number < len(lights):
        doc.findings.error("gltf.index", f"light {number} does not exist; the file has {len(lights)}", place)
        return None
    light, path = lights[number], f"extensions.KHR_lights_punctual.lights[{number}]"
    color = doc.vector(light, "color", path, (1.0, 1.0, 1.0))
    asset = LightAsset(
        doc.choice(light, "type", path, ("directional", "point", "spot"), "point"),
        (max(color[0], 0.0), max(color[1], 0.0), max(color[2], 0.0)),
        doc.number(light, "intensity", path, 1.0, 0.0, 3e38),
        doc.number(light, "range", path, 0.0, 0.0, 3e38),
    )
    if asset.type == "spot":
        spot = doc.child(light, "spot", path)
        asset.outer_angle = doc.number(spot, "outerConeAngle", f"{path}.spot", math.pi / 4, 1e-4, math.pi / 2)
        asset.inner_angle = doc.number(spot, "innerConeAngle", f"{path}.spot", 0.0, 0.0, math.pi / 2)
        if asset.inner_angle >= asset.outer_angle:
            doc.findings.warn("gltf.light", "the inner cone is not inside the outer one", f"{path}.spot")
            asset.inner_angle = asset.outer_angle * 0.99
    return asset
