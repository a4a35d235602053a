"""The worker's task: one FBX file becomes JSON and arrays, in metres and +Y up, with nothing of ufbx left in it.

ufbx converts while it loads: units and axes into the geometry and the nodes' transforms, pivots, pre and post
rotations into plain TRS, geometric transforms into the vertices (or helper nodes where instances share them), and
scale inheritance into helper nodes. `document.py` describes what comes out.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import ufbx
from numpy.typing import NDArray

from engine.core.errors import FormatError
from importers.fbx.diagnose import diagnose
from importers.fbx.extract_animation import read_stacks
from importers.fbx.extract_materials import read_cache_files, read_materials, read_textures
from importers.fbx.extract_meshes import read_mesh
from importers.fbx.native import Handle, load

#: node attributes that ufbx reads and we do not draw
_LEFT_OUT = {
    "nurbs_curves": "NURBS curves", "nurbs_surfaces": "NURBS surfaces", "line_curves": "line curves",
    "procedural_geometries": "procedural geometries", "constraints": "constraints", "audio_clips": "audio clips",
    "characters": "characters",
}  # fmt: skip
_MAX_DEPTH = 1000


@dataclass(slots=True)
class Output:
    """What is sent back. `put` stores an array under a name that the JSON can use."""

    data: dict[str, Any] = field(default_factory=dict)
    arrays: dict[str, NDArray[Any]] = field(default_factory=dict)

    def put(self, values: NDArray[Any]) -> str:
        name = f"a{len(self.arrays)}"
        self.arrays[name] = np.ascontiguousarray(values)
        return name


def extract(request: dict[str, Any]) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Read `request["path"]`. Raises FormatError where ufbx refuses the file, MemoryError where it wants too much."""
    scene = _load(str(request["path"]))
    out = Output()
    out.data["textures"] = read_textures(scene, out)
    out.data["cache_files"] = read_cache_files(scene)
    settings, metadata = scene.settings, scene.metadata
    frame_rate = settings.frames_per_second
    out.data |= {
        "version": metadata.version,
        "ascii": metadata.ascii,
        "big_endian": metadata.big_endian,
        "creator": metadata.creator,
        "application": metadata.original_application.name,
        "frame_rate": frame_rate if 0.1 < frame_rate < 10000 else 30.0,
        "unit_meters": _number(settings.original_unit_meters or settings.unit_meters, 1.0),
        "up_axis": _up_axis(settings),
        "default_camera": settings.default_camera,
        "warnings": [[w.description, w.count] for w in metadata.warnings],
        "left_out": [
            [what, len(getattr(scene, name))] for name, what in _LEFT_OUT.items() if len(getattr(scene, name))
        ],
    }
    _read_nodes(scene, out)
    out.data["meshes"] = [read_mesh(mesh, out) for mesh in scene.meshes]
    out.data["materials"] = read_materials(scene)
    out.data["lights"] = [_light(light) for light in scene.lights]
    out.data["cameras"] = [_camera(camera) for camera in scene.cameras]
    out.data["stacks"] = read_stacks(scene, out, float(out.data["frame_rate"]))
    return out.data, out.arrays


def _up_axis(settings: Handle) -> str:
    """The axis that the file declares to point up: +y, -z, …; +y where it declares none."""
    axis = min(max(int(settings.props.find_int("UpAxis", 1)), 0), 2)
    sign = "-" if int(settings.props.find_int("UpAxisSign", 1)) < 0 else "+"
    return sign + "xyz"[axis]


def _load(path: str) -> Handle:
    axes = ufbx.axes_right_handed_y_up
    try:
        return load(
            path, target_axes=axes, target_unit_meters=1.0, target_camera_axes=axes, target_light_axes=axes,
            space_conversion=ufbx.SpaceConversion.MODIFY_GEOMETRY, handedness_conversion_axis=ufbx.MirrorAxis.X,
            geometry_transform_handling=ufbx.GeometryTransformHandling.MODIFY_GEOMETRY,
            inherit_mode_handling=ufbx.InheritModeHandling.HELPER_NODES,
            geometry_transform_helper_name="geometry", scale_helper_name="scale",
            generate_missing_normals=True, clean_skin_weights=True, node_depth_limit=_MAX_DEPTH,
            use_blender_pbr_material=True,
            load_external_files=False,
        )  # fmt: skip
    except (ufbx.OutOfMemoryError, ufbx.MemoryLimitError, ufbx.AllocationLimitError) as error:
        raise MemoryError from error
    except ufbx.UfbxError as error:
        raise FormatError(_reason(error, path), hint="export it again, as binary FBX 7.4 or newer") from error


def _reason(error: Exception, path: str) -> str:
    text = str(error).strip()
    if isinstance(error, ufbx.TruncatedFileError):
        return "the file ends too early"
    if isinstance(error, ufbx.UnrecognizedFileFormatError):
        return "is no FBX file, neither binary nor ASCII"
    if isinstance(error, ufbx.EmptyFileError):
        return "the file is empty"
    if isinstance(error, ufbx.UnsupportedVersionError):
        return f"this version of FBX cannot be read: {text}"
    if isinstance(error, ufbx.NodeDepthLimitError):
        return f"nodes are nested deeper than {_MAX_DEPTH}"
    if text == "Failed to load" or not text:
        found = diagnose(Path(path).read_bytes())
        return f"breaks the FBX format: {found or 'its reader does not say where'}"
    return f"cannot be read as FBX: {text}"


def _read_nodes(scene: Handle, out: Output) -> None:
    """Parents stand before their children; the first is the root."""
    nodes = list(scene.nodes)
    transforms = [node.local_transform for node in nodes]
    out.data["nodes"] = [_node(node) for node in nodes]
    out.data["translation"] = out.put(np.array([t.translation for t in transforms], np.float64).reshape(-1, 3))
    out.data["rotation"] = out.put(np.array([t.rotation for t in transforms], np.float64).reshape(-1, 4))
    out.data["scale"] = out.put(np.array([t.scale for t in transforms], np.float64).reshape(-1, 3))
    # where ufbx puts the geometry; the identity except for what it could not fold in
    geometry = np.array([node.geometry_to_node for node in nodes], np.float64).reshape(-1, 4, 3)
    out.data["node_from_geometry"] = out.put(geometry.transpose(0, 2, 1))


def _node(node: Handle) -> dict[str, Any]:
    kind = ufbx.ElementType(int(node.attrib_type)).name.lower()
    return {
        "name": node.name,
        "parent": _id(node.parent),
        "kind": kind,
        "visible": node.visible or _shown(node),
        "mesh": _id(node.mesh),
        "light": _id(node.light),
        "camera": _id(node.camera),
        "materials": [_id(material) for material in node.materials],
        "root": node.is_root,
        "helper": "scale" if node.is_scale_helper else "geometry" if node.is_geometry_transform_helper else "",
    }


def _shown(node: Handle) -> bool:
    """Old files hold the visibility as a number that ufbx takes for 0."""
    prop = node.props.find_prop("Visibility")
    return prop is not None and float(prop.value_vec4[0]) != 0.0


def _light(light: Handle) -> dict[str, Any]:
    return {
        "name": light.name,
        "type": ufbx.LightType(int(light.type)).name.lower(),
        "decay": ufbx.LightDecay(int(light.decay)).name.lower(),
        "color": [_number(v, 1.0) for v in light.color],
        "intensity": _number(light.intensity, 1.0),
        "inner_angle": _number(light.inner_angle, 0.0),
        "outer_angle": _number(light.outer_angle, 90.0),
        "on": light.cast_light,
        "shadows": light.cast_shadows,
        "shape": ufbx.LightAreaShape(int(light.area_shape)).name.lower(),
    }


def _camera(camera: Handle) -> dict[str, Any]:
    return {
        "name": camera.name,
        "orthographic": int(camera.projection_mode) == int(ufbx.ProjectionMode.ORTHOGRAPHIC),
        "fov_deg": [_number(v, 45.0) for v in camera.field_of_view_deg],
        "size": [_number(v, 1.0) for v in camera.orthographic_size],
        "aspect": _number(camera.aspect_ratio, 0.0),
        "near": _number(camera.near_plane, 0.0),
        "far": _number(camera.far_plane, 0.0),
    }


def _id(element: Handle | None) -> int:
    return -1 if element is None else int(element.typed_id)


def _number(value: float, fallback: float) -> float:
    return float(value) if np.isfinite(value) else fallback
