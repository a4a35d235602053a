"""What is numerically wrong with a scene: transforms, sizes, lights, cameras, materials, clips. Changes nothing.

Every finding names the node or material, where it is in the file, and what to do. Errors are what cannot be shown as
it was meant; warnings will be seen or cost something; the rest is information.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from engine.animation.tracks import pack
from engine.assets.clip import ClipAsset
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import SceneAsset
from engine.core.errors import UsageError
from engine.core.findings import Findings
from engine.core.paths import shaders_dir
from engine.materials.library import EffectLibrary
from engine.materials.pairing import pairing
from engine.materials.suggest import hint
from engine.math.bounds import transform_box
from engine.math.ggx import MIN_ROUGHNESS
from engine.scene.morphs import LARGEST_WEIGHT
from engine.scene.scene import Scene
from importers.checks.light_inside import is_inside
from importers.checks.mesh import check_mesh_numbers

F8 = NDArray[np.float64]

#: what loading says about transforms, which is said here with more detail
ALREADY_SAID = ("scene.number", "scene.rotation", "scene.matrix")
#: Metres: a whole scene outside of these was surely made in other units.
SMALLEST_SCENE, LARGEST_SCENE = 1e-3, 1e5
#: Metres: beyond these a character, or a whole scene, is as likely to be in other units as to be meant so.
USUAL_BODY, USUAL_SCENE = (0.05, 50.0), (1e-2, 1e3)
#: Beyond this a number does not fit the GPU's float32 squared.
LARGEST_NUMBER = 1e18
#: Squashed by more than this, a body is flat to float32.
FLATTEST = 1e-7
#: far : near beyond which a depth buffer of 24 bits, not reversed, shows far surfaces through each other
DEPTH_RATIO = 1e6
#: |q| may be off by this before a rotation is called not normalised; keys may be rounded to 8 bits
ROTATION_SLACK, KEY_SLACK = 1e-3, 2e-2
#: a body smaller than this part of the scene is never seen beside the rest
SPECK = 1e-6


@dataclass(slots=True)
class SceneParts:
    """A scene with what it names. `meshes[i]`: of node i, or None; `places[k]`, `materials[k]`: a material and where it
    is; `clips`: with their places."""

    scene: SceneAsset
    meshes: Sequence[MeshAsset | None] = ()
    materials: Mapping[str, MaterialAsset] = field(default_factory=dict)
    clips: Mapping[str, ClipAsset] = field(default_factory=dict)


def check_scene_numbers(parts: SceneParts, findings: Findings) -> None:
    """Add all numeric findings about the scene to `findings`."""
    _check_nodes(parts, findings)
    scene = Scene.from_asset(parts.scene)
    for finding in scene.findings:  # what loading mends: lights, cameras
        if finding.code in ALREADY_SAID:
            continue
        findings.add(finding.severity, finding.code, finding.message, finding.where.path, finding.hint)
    seen: dict[int, str] = {}
    for index, mesh in enumerate(parts.meshes):
        if mesh is not None and id(mesh) not in seen:
            seen[id(mesh)] = f"nodes[{index}].mesh"
            check_mesh_numbers(mesh, seen[id(mesh)], findings)
    boxes = _boxes(parts, scene)
    _check_sizes(parts, scene, boxes, findings)
    _check_lights(parts, scene, boxes, findings)
    _check_cameras(parts, scene, boxes, findings)
    for place, material in parts.materials.items():
        check_material_numbers(material, place, findings)
    for place, clip in parts.clips.items():
        _check_clip(clip, place, len(parts.scene.nodes), findings)


def check_material_numbers(material: MaterialAsset, path: str, findings: Findings) -> None:
    """Add findings about one material's values, and names that its effect lacks. Unknown effects are left to who loads
    it."""
    library = EffectLibrary([shaders_dir()])
    if material.effect not in library.names():
        return
    effect = library.get(material.effect)
    params = f"{path}.params" if path else "params"
    for name, value in material.params.items():
        param = effect.param_by_name.get(name)
        if param is None:
            _report_unknown(material, "parameter", name, effect.param_by_name, f"{params}.{name}", findings)
            continue
        try:
            param.check(value)
        except UsageError as error:
            findings.error(
                "number.material", f"material {material.name!r}: {error.message}", f"{params}.{name}",
                "give a value in that range; until then the material is drawn in magenta",
            )  # fmt: skip
    for slot in material.textures:
        if slot not in effect.slot_by_name:
            where = f"{path}.textures.{slot}" if path else f"textures.{slot}"
            _report_unknown(material, "texture", slot, effect.slot_by_name, where, findings)
    for wrong, advice in pairing(material.features, material.effect, _number(material.params.get("roughness", 1.0))):
        where = f"{path}.features" if path else "features"
        findings.warn("material.pairing", f"material {material.name!r}: {wrong}", where, advice)
    roughness = material.params.get("roughness", 1.0)
    if isinstance(roughness, (int, float)) and 0.0 <= roughness < MIN_ROUGHNESS and "unlit" not in material.features:
        findings.info(
            "number.roughness", f"material {material.name!r}: roughness {roughness:g} is drawn as {MIN_ROUGHNESS:g}",
            f"{params}.roughness", f"nothing to do, or set {MIN_ROUGHNESS:g}; below that highlights would flicker",
        )  # fmt: skip


def _report_unknown(
    material: MaterialAsset, kind: str, name: str, known: Iterable[str], where: str, findings: Findings
) -> None:
    # a warning, as a project's own effect of that name may well have it
    findings.warn(
        "material.unknown", f"material {material.name!r}: the effect {material.effect!r} has no {kind} {name!r}", where,
        f"{hint(name, known)}; unless the project has an effect of that name, the material is drawn in magenta",
    )  # fmt: skip


def _check_nodes(parts: SceneParts, findings: Findings) -> None:
    for index, node in enumerate(parts.scene.nodes):
        where, name = f"nodes[{index}]", f"node {node.name!r}"
        for column in ("translation", "rotation", "scale", "matrix"):
            values = getattr(node, column)
            if values is not None and not all(map(math.isfinite, values)):
                findings.error(
                    "number.transform", f"{name}: {column} {list(values)} is not finite", f"{where}.{column}",
                    "set it again; until then it counts as none",
                )  # fmt: skip
        bad = [w for w in node.weights if not abs(w) <= LARGEST_WEIGHT]
        if bad:
            findings.error(
                "number.morph-weight", f"{name}: the morph weight {bad[0]:g} is beyond all use", f"{where}.weights",
                f"set it between 0 and 1; it counts as 0 or as {LARGEST_WEIGHT:g}",
            )  # fmt: skip
        length = math.hypot(*node.rotation)
        if length < 1e-30:
            findings.error(
                "number.rotation", f"{name}: the rotation has length 0", f"{where}.rotation", "set it to (0, 0, 0, 1)"
            )
        elif math.isfinite(length) and abs(length - 1.0) > ROTATION_SLACK:
            findings.warn(
                "number.rotation", f"{name}: the rotation has length {length:g}, not 1", f"{where}.rotation",
                "normalise it; it is read as if it were",
            )  # fmt: skip
        if node.matrix is None and 0.0 in node.scale:
            findings.warn(
                "number.scale-zero", f"{name}: scale {list(node.scale)} flattens everything below it", f"{where}.scale",
                "switch the node's visibility off instead, or give it a scale above 0",
            )  # fmt: skip


def _boxes(parts: SceneParts, scene: Scene) -> dict[int, tuple[F8, F8]]:
    """The box in the world of each node with a mesh, by node index."""
    boxes = {}
    for index, mesh in enumerate(parts.meshes):
        if mesh is None or not mesh.submeshes:
            continue
        low = np.min([s.bounds_min for s in mesh.submeshes], axis=0)
        high = np.max([s.bounds_max for s in mesh.submeshes], axis=0)
        with np.errstate(over="ignore", invalid="ignore"):
            box = transform_box(_world(scene, index), low, high)
        if np.isfinite(box).all():
            boxes[index] = box
    return boxes


def _world(scene: Scene, index: int) -> F8:
    return scene.nodes.world_matrix(int(scene.row_of_node[index]))


def _check_sizes(parts: SceneParts, scene: Scene, boxes: dict[int, tuple[F8, F8]], findings: Findings) -> None:
    for index, mesh in enumerate(parts.meshes):
        node = parts.scene.nodes[index]
        if mesh is None:
            continue
        linear = _world(scene, index)[:3, :3]
        if np.abs(linear).max() > LARGEST_NUMBER or index not in boxes:
            findings.error(
                "number.scale", f"node {node.name!r}: its world transform is beyond all bounds", f"nodes[{index}]",
                "look for huge scales in the nodes above it",
            )  # fmt: skip
            continue
        sizes = np.linalg.svd(linear, compute_uv=False)
        if sizes[2] < FLATTEST * sizes[0] and 0.0 not in node.scale:
            findings.warn(
                "number.flat", f"node {node.name!r}: its mesh is squashed to {sizes[2]:.1g} against {sizes[0]:.1g}",
                f"nodes[{index}]", "look for a scale near 0 in this node or above it",
            )  # fmt: skip
    if not boxes:
        return
    # the longest side, not the diagonal: squares of 1e300 overflow
    size = float((np.max([b[1] for b in boxes.values()], 0) - np.min([b[0] for b in boxes.values()], 0)).max())
    for index, (low, high) in boxes.items():
        own = float((high - low).max())
        if 0.0 < own < SPECK * size:
            findings.warn(
                "number.speck", f"node {parts.scene.nodes[index].name!r}: {own:.2g} m across, the scene {size:.2g} m",
                f"nodes[{index}]", "look for a scale or a unit that does not fit the rest of the scene",
            )  # fmt: skip
    if size < SMALLEST_SCENE or size > LARGEST_SCENE:
        findings.warn(
            "number.units", f"the whole scene is {size:.3g} m across", "nodes",
            "check the exporter's unit; lengths here are metres. It is drawn right, but ranges, speeds and shadows "
            "are tuned for metres",
        )  # fmt: skip
        return
    for index, (low, high) in boxes.items():
        node, own = parts.scene.nodes[index], float((high - low).max())
        if node.joints and own > 0.0 and not USUAL_BODY[0] <= own <= USUAL_BODY[1]:
            findings.warn(
                "number.units", f"node {node.name!r}: a skinned mesh of {own:.3g} m, a suspicious scale",
                f"nodes[{index}]", f"check the exporter's unit{_unit_hint(own, USUAL_BODY)}",
            )  # fmt: skip
            return
    if size > 0.0 and not USUAL_SCENE[0] <= size <= USUAL_SCENE[1]:
        findings.info(
            "number.units", f"the whole scene is {size:.3g} m across, a suspicious scale", "nodes",
            f"check the exporter's unit, unless it is meant so{_unit_hint(size, USUAL_SCENE)}",
        )  # fmt: skip


def _unit_hint(size: float, usual: tuple[float, float]) -> str:
    """What `size` would be in units smaller than metres, where one makes it usual."""
    for name, metres in (("centimetres", 0.01), ("millimetres", 0.001), ("inches", 0.0254)):
        if size > usual[1] and usual[0] <= size * metres <= usual[1]:
            return f"; in {name} it would be {size * metres:.3g} m"
    return ""


def _check_lights(parts: SceneParts, scene: Scene, boxes: dict[int, tuple[F8, F8]], findings: Findings) -> None:
    for index, node in enumerate(parts.scene.nodes):
        if node.light is None or node.light.type == "directional":
            continue
        position = _world(scene, index)[:3, 3]
        for body, (low, high) in boxes.items():
            mesh = parts.meshes[body]
            if mesh is None or not ((position > low) & (position < high)).all():
                continue
            if is_inside(position, mesh, _world(scene, body)):
                other = parts.scene.nodes[body].name
                findings.warn(
                    "number.light-inside", f"light {node.name!r} lies inside the body of node {other!r}",
                    f"nodes[{index}].light", "move it out, or it will light nothing where shadows are cast",
                )  # fmt: skip


def _check_cameras(parts: SceneParts, scene: Scene, boxes: dict[int, tuple[F8, F8]], findings: Findings) -> None:
    corners = np.array([c for low, high in boxes.values() for c in _corners(low, high)], np.float64).reshape(-1, 3)
    for index, node in enumerate(parts.scene.nodes):
        camera = node.camera
        if camera is None or camera.type != "perspective" or not camera.znear > 0.0:
            continue
        where, name = f"nodes[{index}].camera.znear", f"camera {node.name!r}"
        pose = _world(scene, index)
        depth = -(corners - pose[:3, 3]) @ pose[:3, 2] / max(float(np.linalg.norm(pose[:3, 2])), 1e-300)
        farthest = float(depth.max()) if len(depth) else 0.0
        if len(depth) and farthest > 0.0 and camera.znear > farthest:
            findings.warn(
                "number.near", f"{name}: the near plane, {camera.znear:g} m, lies behind everything it could see",
                where, f"set it below {farthest:.3g}",
            )  # fmt: skip
        far = camera.zfar or farthest
        if far > camera.znear * DEPTH_RATIO:
            findings.warn(
                "number.depth-range", f"{name}: far : near is {far / camera.znear:.1g} : 1", where,
                f"raise the near plane towards {far / DEPTH_RATIO:.2g} m; where reversed depth is missing, surfaces "
                "flicker through each other",
            )  # fmt: skip


def _corners(low: F8, high: F8) -> list[F8]:
    both = np.stack([low, high])
    return [np.array([both[i, 0], both[j, 1], both[k, 2]]) for i in (0, 1) for j in (0, 1) for k in (0, 1)]


def _check_clip(clip: ClipAsset, path: str, nodes: int, findings: Findings) -> None:
    for index, channel in enumerate(clip.channels):
        keys = np.asarray(channel.values, np.float64)
        if channel.path != "rotation" or keys.ndim < 2 or keys.shape[-1] != 4 or not keys.size:
            continue
        length = np.linalg.norm(
            keys[:, 1] if keys.ndim == 3 else keys, axis=-1
        )  # of a cubic key the value, no tangents
        off = np.isfinite(length) & (np.abs(length - 1.0) > KEY_SLACK)
        if off.any():
            findings.warn(
                "number.clip-rotation", f"clip {clip.name!r}: {np.count_nonzero(off):,} rotation keys of "
                f"{channel.target or f'node {channel.node}'!r} have not length 1 (first {length[off][0]:.3g})",
                f"{path}.channels[{index}].values", "export the animation again; they are read as if they were",
            )  # fmt: skip
    notes = Findings()
    pack(clip, np.arange(nodes), notes)
    for finding in notes:
        findings.add(
            finding.severity, finding.code, f"clip {clip.name!r}: {finding.message}", f"{path}.{finding.where.path}",
            finding.hint or "export the animation again; it is played as described",
        )  # fmt: skip


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, (int, float)) else None
