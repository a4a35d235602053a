"""Scenes and sources as GLB: hierarchy, meshes, skins, morphs, clips, materials with their images, cameras, lights.

Numbers go out as they are kept (float32 positions and keys, 16-bit colours and weights), so that import -> export ->
import gives the same. What glTF has no word for goes into extras, under `lucarna`; what cannot go is a finding.

Source: glTF 2.0 specification (Khronos, 2021); KHR_lights_punctual, KHR_node_visibility; materials: glb_materials.py.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.clip import ClipAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import CameraAsset, EnvironmentAsset, LightAsset, LookAsset, NodeAsset
from engine.core.atomic import write_bytes
from engine.math.blackbody import black_body
from importers.export.glb_materials import MaterialWriter
from importers.export.glb_writer import INDICES, VERTICES, GlbWriter
from importers.export.source import ExportSource
from importers.gltf.extras import CLIP_KEYS, MESH_KEYS, NODE_KEYS, OWN, split_extras
from importers.gltf.variants import EXTRAS as VARIANTS
from importers.gltf.variants import NAME as VARIANTS_NAME

GENERATOR = "Lucarna"
_MODES = {"points": 0, "lines": 1, "triangles": 4}
#: where an orthographic camera ends that has no end of its own, in metres: glTF wants one
FAR = 1e4


def export_glb(out: Path, source: ExportSource) -> None:
    """Write `glb_bytes` atomically. Raises OutputError."""
    write_bytes(out, glb_bytes(source))


def glb_bytes(source: ExportSource) -> bytes:
    """The whole source as a GLB file; findings are added to its own."""
    return _Export(source).run()


class _Export:
    def __init__(self, source: ExportSource) -> None:
        self._source = source
        self._writer = GlbWriter(GENERATOR)
        self._materials = MaterialWriter(source, self._writer)
        self._attributes: dict[int, dict[str, int]] = {}
        self._targets: dict[int, list[dict[str, int]]] = {}
        self._meshes: dict[tuple[int, tuple[int, ...]], int] = {}

    def run(self) -> bytes:
        source, writer = self._source, self._writer
        scene: dict[str, Any] = {"name": source.name}
        roots = [row for row, node in enumerate(source.nodes) if node.parent < 0]
        if roots:
            scene["nodes"] = roots
        surroundings = _surroundings(source.environment, source.look)
        if source.environment.kind == "image":
            source.findings.warn("export.environment", "the environment's image is not written", "environment")
            surroundings.pop("environment", None)
        if surroundings:
            scene["extras"] = {OWN: surroundings}
        writer.root |= {"scene": 0, "scenes": [scene]}
        children: dict[int, list[int]] = {}
        for row, node in enumerate(source.nodes):
            children.setdefault(node.parent, []).append(row)
        for row, node in enumerate(source.nodes):
            writer.append("nodes", self._node(row, node, children.get(row, [])))
        for clip in source.clips:
            self._clip(clip)
        return writer.bytes()

    def _node(self, row: int, node: NodeAsset, children: list[int]) -> dict[str, Any]:
        entry: dict[str, Any] = {"name": node.name}
        if node.matrix is not None:
            entry["matrix"] = list(node.matrix)
        else:
            for key, value, neutral in (
                ("translation", node.translation, (0, 0, 0)), ("rotation", node.rotation, (0, 0, 0, 1)),
                ("scale", node.scale, (1, 1, 1)),
            ):  # fmt: skip
                if tuple(value) != neutral:
                    entry[key] = list(value)
        if children:
            entry["children"] = children
        if node.mesh is not None and 0 <= node.mesh.index < len(self._source.meshes):
            mesh = self._source.meshes[node.mesh.index]
            entry["mesh"] = self._mesh(node.mesh.index, tuple(self._source.materials_of[row]))
            if node.joints and mesh.skeleton is not None:
                matrices = mesh.skeleton.inverse_bind.transpose(0, 2, 1).reshape(-1, 16).astype("<f4")
                entry["skin"] = self._writer.add(
                    "skins", {"inverseBindMatrices": self._writer.accessor(matrices), "joints": list(node.joints)}
                )
            if node.weights and mesh.morphs:
                entry["weights"] = list(node.weights)
        if node.camera is not None:
            entry["camera"] = self._writer.append("cameras", _camera(node.camera))
        extensions: dict[str, Any] = {}
        if node.light is not None:
            holder = self._writer.root.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})
            extensions["KHR_lights_punctual"] = {"light": len(holder["lights"])}
            holder["lights"].append(_light(node.light))
            self._writer.use("KHR_lights_punctual")
            lost = _lost_in(node.light)
            if lost:
                self._source.findings.warn("export.light", f"glTF has no word for {lost}", node.name)
        if not node.visible:
            extensions["KHR_node_visibility"] = {"visible": False}
            self._writer.use("KHR_node_visibility")
        if extensions:
            entry["extensions"] = extensions
        extras = split_extras(node.extras, NODE_KEYS)
        if "skin_bind_world" in node.extras:
            self._source.findings.info(
                "export.skin",
                "the skinned mesh moves with its node; other programs move it by its joints alone",
                node.name,
            )
        if extras:
            entry["extras"] = extras
        return entry

    def _mesh(self, index: int, materials: tuple[int, ...]) -> int:
        key = index, materials
        if key in self._meshes:
            return self._meshes[key]
        mesh = self._source.meshes[index]
        if index not in self._attributes:
            self._attributes[index] = self._streams(mesh)
            self._targets[index] = self._morphs(mesh)
        wide = mesh.vertex_count > 0xFFFF
        primitives = []
        for part in mesh.submeshes:
            run = mesh.indices[part.first_index : part.first_index + part.index_count]
            primitive: dict[str, Any] = {
                "attributes": self._attributes[index], "mode": _MODES[part.topology],
                "indices": self._writer.accessor(run.astype("<u4" if wide else "<u2"), target=INDICES),
            }  # fmt: skip
            material = materials[part.material_slot] if part.material_slot < len(materials) else -1
            if material >= 0:
                primitive["material"] = self._materials.index(material)
            if self._targets[index]:
                primitive["targets"] = self._targets[index]
            self._variants(mesh, part.material_slot, primitive)
            primitives.append(primitive)
        entry: dict[str, Any] = {"name": mesh.name, "primitives": primitives}
        kept = {k: v for k, v in mesh.extras.items() if k != VARIANTS}
        extras = split_extras(kept, MESH_KEYS)
        if mesh.morphs:
            extras["targetNames"] = [morph.name for morph in mesh.morphs]
        if extras:
            entry["extras"] = extras
        if mesh.extras.get("skinning") == "dual_quaternion":
            self._source.findings.info(
                "export.skin", "is skinned by dual quaternions; other programs blend its joints linearly", mesh.name
            )
        self._meshes[key] = self._writer.append("meshes", entry)
        return self._meshes[key]

    def _variants(self, mesh: MeshAsset, slot: int, primitive: dict[str, Any]) -> None:
        """What the source said of its variants, where its materials are still known by number."""
        kept = mesh.extras.get(VARIANTS)
        if not isinstance(kept, dict):
            return
        names, slots = kept.get("names"), kept.get("slots")
        if not isinstance(names, list) or not isinstance(slots, list) or not slot < len(slots):
            return
        known = len(self._source.materials)
        mappings = [
            {"material": self._materials.index(material), "variants": [k]}
            for k, material in enumerate(slots[slot])
            if isinstance(material, int) and 0 <= material < known
        ]
        if mappings:
            primitive["extensions"] = {VARIANTS_NAME: {"mappings": mappings}}
            root = self._writer.root.setdefault("extensions", {})
            root[VARIANTS_NAME] = {"variants": [{"name": str(name)} for name in names]}
            self._writer.use(VARIANTS_NAME)

    def _streams(self, mesh: MeshAsset) -> dict[str, int]:
        streams, writer = mesh.streams, self._writer
        result = {"POSITION": writer.accessor(_floats(streams["position"]), target=VERTICES, bounds=True)}
        result["NORMAL"] = writer.accessor(_unsnorm(streams["normal"][:, :3]), target=VERTICES)
        if "tangent" in streams:
            result["TANGENT"] = writer.accessor(_unsnorm(streams["tangent"]), target=VERTICES)
        for number in (0, 1):
            if f"uv{number}" in streams:
                result[f"TEXCOORD_{number}"] = writer.accessor(_floats(streams[f"uv{number}"]), target=VERTICES)
        if "color" in streams:
            result["COLOR_0"] = writer.accessor(np.asarray(streams["color"]), normalized=True, target=VERTICES)
        for number, suffix in enumerate(("", "1")):
            if f"joints{suffix}" in streams:
                joints, weights = np.asarray(streams[f"joints{suffix}"]), np.asarray(streams[f"weights{suffix}"])
                result[f"JOINTS_{number}"] = writer.accessor(joints, target=VERTICES)
                result[f"WEIGHTS_{number}"] = writer.accessor(weights, normalized=True, target=VERTICES)
        return result

    def _morphs(self, mesh: MeshAsset) -> list[dict[str, int]]:
        streams = sorted({name for morph in mesh.morphs for name in morph.streams}) or ["position"]
        none = np.zeros((mesh.vertex_count, 3), "<f4")
        return [
            {
                name.upper(): self._writer.accessor(
                    _floats(morph.streams.get(name, none)), target=VERTICES, bounds=name == "position"
                )
                for name in streams
            }
            for morph in mesh.morphs
        ]

    def _clip(self, clip: ClipAsset) -> None:
        samplers: list[dict[str, Any]] = []
        channels: list[dict[str, Any]] = []
        names = {"step": "STEP", "linear": "LINEAR", "cubic": "CUBICSPLINE"}
        for channel in clip.channels:
            if not 0 <= channel.node < len(self._source.nodes) or not len(channel.times):
                continue
            width = 1 if channel.path == "weights" else channel.values.shape[-1]
            sampler = {
                "input": self._writer.accessor(_floats(channel.times), bounds=True),
                "output": self._writer.accessor(_floats(channel.values).reshape(-1, width)),
                "interpolation": names[channel.interpolation],
            }
            channels.append(
                {"sampler": len(samplers), "target": {"node": channel.node, "path": channel.path}}
            )  # fmt: skip
            samplers.append(sampler)
        if not channels:
            return
        entry: dict[str, Any] = {"name": clip.name, "channels": channels, "samplers": samplers}
        own = {k: v for k, v in zip(CLIP_KEYS, (clip.start, clip.frame_rate), strict=True) if v}
        if own:
            entry["extras"] = {OWN: own}
        self._writer.append("animations", entry)


def _floats(values: NDArray[Any]) -> NDArray[np.float32]:
    return np.asarray(values, "<f4")


def _unsnorm(values: NDArray[Any]) -> NDArray[np.float32]:
    return np.maximum(np.asarray(values, np.float64) / 32767.0, -1.0).astype("<f4")


def _camera(camera: CameraAsset) -> dict[str, Any]:
    lens: dict[str, Any] = {"znear": camera.znear}
    if camera.type == "perspective":
        lens["yfov"] = camera.yfov
        if camera.aspect:
            lens["aspectRatio"] = camera.aspect
        if camera.zfar:
            lens["zfar"] = camera.zfar
    else:
        lens |= {"xmag": camera.ymag * (camera.aspect or 1.0), "ymag": camera.ymag, "zfar": camera.zfar or FAR}
    return {"type": camera.type, camera.type: lens}


def _lost_in(light: LightAsset) -> str:
    """What of a light cannot go out, and what stands for it; '' for nothing."""
    if light.type in ("rectangle", "disk"):
        return f"a {light.type} light; a spot light of the same candela straight ahead stands for it"
    return "the light's IES profile; its brightest candela count all around" if light.profile else ""


def _light(light: LightAsset) -> dict[str, Any]:
    color, intensity, kind = np.asarray(light.color, np.float64), light.intensity, light.type
    if light.temperature:
        color = color * black_body(light.temperature)
    if kind in ("rectangle", "disk"):
        intensity *= light.width * light.height * (math.pi / 4.0 if kind == "disk" else 1.0)
        kind = "spot"
    # colours above 1 go into the intensity: glTF allows none
    peak = float(color.max())
    if peak > 1.0:
        color, intensity = color / peak, intensity * peak
    entry: dict[str, Any] = {"type": kind, "color": np.maximum(color, 0.0).tolist(), "intensity": intensity}
    if light.range and light.type != "directional":
        entry["range"] = light.range
    if kind == "spot" and light.type != "spot":
        entry["spot"] = {"innerConeAngle": 0.0, "outerConeAngle": math.pi / 2.0}
    elif kind == "spot":
        entry["spot"] = {"innerConeAngle": light.inner_angle, "outerConeAngle": light.outer_angle}
    return entry


def _surroundings(environment: EnvironmentAsset, look: LookAsset) -> dict[str, Any]:
    """What differs from the defaults, in the words of a scene file."""
    result = {}
    for key, value in (("environment", environment), ("look", look)):
        plain = dataclasses.asdict(type(value)())
        changed = {k: v for k, v in dataclasses.asdict(value).items() if v != plain[k]}
        if changed:
            result[key] = {k: list(v) if isinstance(v, tuple) else v for k, v in changed.items()}
    return result
