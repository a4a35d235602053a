"""`.lmesh`: all meshes of one source in one safetensors container, mapped straight into arrays the GPU takes.

Arrays of mesh i: `m<i>.<stream>`, `m<i>.indices`, `m<i>.joint_parents`, `m<i>.inverse_bind`,
`m<i>.t<k>.<stream>` for morph target k. Metadata, schema `lucarna.mesh/1`:

    {"schema", "provenance": {…}, "meshes": [{"name", "streams", "submeshes": [[first, count, slot, topology,
     [min], [max]]], "joints": [names] or null, "morphs": [{"name", "streams"}], "extras",
     "quantized": {array: [[low], [step]]}, where there is any (see engine.assets.quantized)}]}
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.assets.container import Arrays, read_container, write_container
from engine.assets.mesh import STREAMS, TOPOLOGIES, MeshAsset, MorphTarget, Skeleton, Submesh
from engine.assets.quantized import Box, decode, encode
from engine.core.errors import FormatError, Place

SCHEMA = "lucarna.mesh/1"
_STEP = {"triangles": 3, "lines": 2, "points": 1}
_MORPH_STREAMS = ("position", "normal", "tangent")
#: streams that are stored in 16 bits where a mesh asks for it by `extras["quantize"]`
_QUANTIZED = ("position", "uv0", "uv1")


def write_lmesh(path: Path, meshes: Sequence[MeshAsset], provenance: Mapping[str, str] | None = None) -> None:
    """Write `meshes`. `provenance` says what they were made from (source, source_hash, importer …).

    Checks them as `read_lmesh` does, so a file that was written can be read. Raises FormatError, OutputError.
    """
    arrays: dict[str, NDArray[Any]] = {}
    described = []
    for i, mesh in enumerate(meshes):
        check_mesh(mesh, Place(str(path), path=f"meshes[{i}]"))
        for stream in mesh.layout:
            arrays[f"m{i}.{stream}"] = mesh.streams[stream]
        arrays[f"m{i}.indices"] = mesh.indices
        if mesh.skeleton is not None:
            arrays[f"m{i}.joint_parents"] = mesh.skeleton.parents
            arrays[f"m{i}.inverse_bind"] = mesh.skeleton.inverse_bind
        for k, morph in enumerate(mesh.morphs):
            for stream in sorted(morph.streams):
                arrays[f"m{i}.t{k}.{stream}"] = morph.streams[stream]
        entry = _describe(mesh)
        if mesh.extras.get("quantize") is True:
            boxes: dict[str, Any] = {}
            for name in [n for n in arrays if n.startswith(f"m{i}.") and n.rpartition(".")[2] in _QUANTIZED]:
                if arrays[name].dtype == np.dtype("<f4"):
                    arrays[name], box = encode(arrays[name])
                    boxes[name.partition(".")[2]] = box.to_json()
            entry["quantized"] = boxes
        described.append(entry)
    write_container(path, {"schema": SCHEMA, "meshes": described, "provenance": dict(provenance or {})}, arrays)


def read_lmesh(path: Path) -> list[MeshAsset]:
    """The meshes of a file; arrays are read-only views of the mapped file.

    Checked: dtypes, lengths, index ranges, submesh runs, joints, bounds. Raises InputError, FormatError.
    """
    metadata, arrays = read_container(path, SCHEMA)
    meshes = []
    listed = metadata.get("meshes")
    if not isinstance(listed, list):
        raise FormatError("metadata has no list of meshes", where=path)
    for i, entry in enumerate(listed):
        place = Place(str(path), path=f"meshes[{i}]")
        try:
            mesh = _mesh(i, entry, arrays)
        except (KeyError, TypeError, ValueError, AttributeError, OverflowError) as error:
            raise FormatError(f"bad description: {type(error).__name__}: {error}", where=place) from error
        check_mesh(mesh, place)
        meshes.append(mesh)
    return meshes


def read_provenance(path: Path) -> dict[str, str]:
    """What the meshes were made from."""
    metadata, _ = read_container(path, SCHEMA)
    found = metadata.get("provenance")
    return {str(k): str(v) for k, v in found.items()} if isinstance(found, dict) else {}


def check_mesh(mesh: MeshAsset, place: Place) -> None:
    """Raise FormatError at `place` when `mesh` breaks its contract (see engine.assets.mesh)."""

    def fail(message: str, path: str = "") -> None:
        raise FormatError(message, where=Place(place.file, path=place.path + path))

    for required in ("position", "normal"):
        if required not in mesh.streams:
            fail(f"has no {required} stream", ".streams")
    count = mesh.vertex_count
    for name, stream in mesh.streams.items():
        if name not in STREAMS:
            fail(f"unknown stream; known: {', '.join(STREAMS)}", f".{name}")
        dtype, components = STREAMS[name]
        if stream.dtype != np.dtype(dtype) or stream.shape != (count, components):
            fail(f"is {stream.dtype}{list(stream.shape)}, expected {dtype}{[count, components]}", f".{name}")
    indices = mesh.indices
    if indices.dtype != np.dtype("<u4") or indices.ndim != 1:
        fail(f"is {indices.dtype}{list(indices.shape)}, expected <u4[n]", ".indices")
    if len(indices) and int(indices.max()) >= count:
        fail(f"index {int(indices.max())} is outside the {count} vertices", ".indices")
    for k, part in enumerate(mesh.submeshes):
        where = f".submeshes[{k}]"
        if part.topology not in TOPOLOGIES:
            fail(f"topology {part.topology!r} is none of {', '.join(TOPOLOGIES)}", where)
        first, length = part.first_index, part.index_count
        if first < 0 or length < 0 or first + length > len(indices):
            fail(f"run {first}+{length} is outside the {len(indices)} indices", where)
        if length % _STEP[part.topology]:
            fail(f"{length} indices are no whole number of {part.topology}", where)
        if not 0 <= part.material_slot <= 0xFFFF:
            fail(f"material slot {part.material_slot} is outside 0..65535", where)
        low, high = part.bounds_min, part.bounds_max
        if not all(map(math.isfinite, (*low, *high))) or any(a > b for a, b in zip(low, high, strict=True)):
            fail(f"bounds {low}..{high} are not finite and ordered", where)
    _check_skeleton(mesh, fail)
    for k, morph in enumerate(mesh.morphs):
        for name, values in morph.streams.items():
            if name not in _MORPH_STREAMS or values.dtype != np.dtype("<f4") or values.shape != (count, 3):
                fail(f"is {values.dtype}{list(values.shape)}, expected <f4[{count}, 3]", f".morphs[{k}].{name}")


def _check_skeleton(mesh: MeshAsset, fail: Any) -> None:
    if mesh.skeleton is None:
        return
    joints = len(mesh.skeleton.names)
    parents, inverse_bind = mesh.skeleton.parents, mesh.skeleton.inverse_bind
    if parents.dtype != np.dtype("<i4") or parents.shape != (joints,):
        fail(f"is {parents.dtype}{list(parents.shape)}, expected <i4[{joints}]", ".skeleton.parents")
    if inverse_bind.dtype != np.dtype("<f4") or inverse_bind.shape != (joints, 4, 4):
        fail(f"is {inverse_bind.dtype}{list(inverse_bind.shape)}, expected <f4[{joints}, 4, 4]", ".skeleton")
    if joints and (np.any(parents < -1) or np.any(parents >= np.arange(joints))):
        fail("a parent does not come before its joint", ".skeleton.parents")
    if not np.isfinite(inverse_bind).all():
        fail("is not finite", ".skeleton.inverse_bind")
    for name in ("joints", "joints1"):
        stream = mesh.streams.get(name)
        if stream is not None and stream.size and int(cast("NDArray[np.uint16]", stream).max()) >= joints:
            fail(f"names a joint outside the skeleton's {joints}", f".{name}")


def _describe(mesh: MeshAsset) -> dict[str, Any]:
    return {
        "name": mesh.name,
        "streams": list(mesh.layout),
        "submeshes": [
            [
                int(s.first_index), int(s.index_count), int(s.material_slot), s.topology,
                [float(v) for v in s.bounds_min], [float(v) for v in s.bounds_max],
            ]
            for s in mesh.submeshes
        ],
        "joints": list(mesh.skeleton.names) if mesh.skeleton is not None else None,
        "morphs": [{"name": m.name, "streams": sorted(m.streams)} for m in mesh.morphs],
        "extras": mesh.extras,
    }  # fmt: skip


def _mesh(i: int, entry: Any, arrays: Arrays) -> MeshAsset:
    quantized = entry.get("quantized") or {}
    if quantized:
        boxes = {f"m{i}.{name}": Box.from_json(box) for name, box in quantized.items()}
        arrays = {name: decode(a, boxes[name]) if name in boxes else a for name, a in arrays.items()}
    streams = {str(name): arrays[f"m{i}.{name}"] for name in entry["streams"]}
    submeshes = []
    for first, count, slot, topology, low, high in entry["submeshes"]:
        submeshes.append(Submesh(_int(first), _int(count), _int(slot), str(topology), _vec3(low), _vec3(high)))
    skeleton = None
    if entry["joints"] is not None:
        skeleton = Skeleton(
            [str(name) for name in entry["joints"]],
            cast("NDArray[np.int32]", arrays[f"m{i}.joint_parents"]),
            cast("NDArray[np.float32]", arrays[f"m{i}.inverse_bind"]),
        )
    morphs = [
        MorphTarget(
            str(morph["name"]),
            {str(s): cast("NDArray[np.float32]", arrays[f"m{i}.t{k}.{s}"]) for s in morph["streams"]},
        )
        for k, morph in enumerate(entry["morphs"])
    ]
    extras = dict(entry["extras"])
    indices = cast("NDArray[np.uint32]", arrays[f"m{i}.indices"])
    for stream in streams.values():
        if stream.ndim != 2:
            raise ValueError("a stream is not two-dimensional")
    return MeshAsset(str(entry["name"]), streams, indices, submeshes, skeleton, morphs, extras)


def _int(value: Any) -> int:
    if type(value) is not int:
        raise ValueError(f"{value!r} is not a whole number")
    return value


def _vec3(value: Any) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in value)
    return x, y, z
