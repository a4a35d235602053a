"""What is numerically wrong with one mesh: positions, normals, tangents, triangles, skin. Reports; changes nothing."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset
from engine.core.findings import Findings
from importers.geometry.topology import zero_area

#: A unit vector stored as snorm16 is this near to length 1; anything below is no direction.
SHORTEST_UNIT = 0.5
#: Every mesh from a modeller has a few triangles without area; beyond this part of all it is worth a word.
ZERO_AREA_PART = 0.05
#: A mesh should be this many float32 steps across, or its rounding is seen.
COARSEST = 10_000
#: Weights are unorm16 and sum to 65535; each of eight may be rounded by half.
WEIGHT_SLACK = 8


def check_mesh_numbers(mesh: MeshAsset, path: str, findings: Findings) -> None:
    """Add findings about `mesh`, found at `path` of the file."""
    name = f"mesh {mesh.name!r}"
    position = mesh.streams["position"]
    bad = _rows_not_finite(position)
    if bad.any():
        findings.error(
            "number.position", f"{name}: {_count(bad)} positions are not finite", f"{path}.position",
            "export the mesh again; the triangles with these corners are not drawn",
        )  # fmt: skip
    for uv in ("uv0", "uv1"):
        if uv in mesh.streams and (broken := _rows_not_finite(mesh.streams[uv])).any():
            findings.error(
                "number.uv", f"{name}: {_count(broken)} texture coordinates are not finite", f"{path}.{uv}",
                "unwrap the mesh again, or export it again",
            )  # fmt: skip
    for index, target in enumerate(mesh.morphs):
        for stream, values in target.streams.items():
            if (broken := _rows_not_finite(np.asarray(values))).any():
                findings.error(
                    "number.morph", f"{name}: morph target {target.name!r} has {_count(broken)} {stream} offsets that "
                    "are not finite", f"{path}.morphs[{index}].{stream}", "sculpt it again, or export it again",
                )  # fmt: skip
    _check_directions(mesh, name, path, findings)
    if not bad.any():
        _check_place(position, name, path, findings)
        _check_triangles(mesh, name, path, findings)
    _check_skin(mesh, name, path, findings)


def _check_place(position: NDArray[Any], name: str, path: str, findings: Findings) -> None:
    """Whether the mesh lies so far from its own origin that float32 rounds its shape away."""
    if len(position) == 0:
        return
    values = np.asarray(position, np.float64)
    size = float((values.max(axis=0) - values.min(axis=0)).max())
    step = float(np.spacing(np.float32(np.abs(values).max())))
    if 0.0 < size < COARSEST * step:
        findings.warn(
            "number.far-origin", f"{name}: {size:.3g} m across, but so far from its own origin that positions are "
            f"rounded to {step:.1g} m", f"{path}.position",
            "move the mesh's origin to the mesh and put the distance into its node",
        )  # fmt: skip


def _check_directions(mesh: MeshAsset, name: str, path: str, findings: Findings) -> None:
    for stream, remedy in (("normal", "recalculate the normals"), ("tangent", "let the importer make the tangents")):
        if stream not in mesh.streams:
            continue
        vectors = np.asarray(mesh.streams[stream], np.float64)[:, :3] / 32767.0
        short = np.einsum("ij,ij->i", vectors, vectors) < SHORTEST_UNIT**2
        if short.any():
            findings.warn(
                f"number.{stream}", f"{name}: {_count(short)} {stream}s have no length", f"{path}.{stream}",
                f"{remedy}; such vertices are lit as if they faced nowhere",
            )  # fmt: skip


def _check_triangles(mesh: MeshAsset, name: str, path: str, findings: Findings) -> None:
    runs = [
        mesh.indices[s.first_index : s.first_index + s.index_count] for s in mesh.submeshes if s.topology == "triangles"
    ]
    indices = np.concatenate(runs).reshape(-1, 3) if runs else np.zeros((0, 3), np.uint32)
    if len(indices) == 0:
        return
    thin = zero_area(np.asarray(mesh.streams["position"], np.float32), indices)
    if thin.mean() > ZERO_AREA_PART:
        findings.warn(
            "number.zero-area", f"{name}: {_count(thin)} of {len(indices):,} triangles have no area", path,
            "merge vertices by distance and dissolve degenerate faces; they cost time and show nothing",
        )  # fmt: skip


def _check_skin(mesh: MeshAsset, name: str, path: str, findings: Findings) -> None:
    if "weights" not in mesh.streams:
        return
    total = np.asarray(mesh.streams["weights"], np.int64).sum(axis=1)
    if "weights1" in mesh.streams:
        total = total + np.asarray(mesh.streams["weights1"], np.int64).sum(axis=1)
    off = np.abs(total - 65535) > WEIGHT_SLACK
    if off.any():
        findings.warn(
            "number.weights", f"{name}: the skin weights of {_count(off)} vertices do not sum to 1", f"{path}.weights",
            "normalise the weights; such vertices move towards or away from the skeleton's origin",
        )  # fmt: skip
    if mesh.skeleton is None or not len(mesh.skeleton.inverse_bind):
        return
    sizes = np.linalg.svd(np.asarray(mesh.skeleton.inverse_bind, np.float64)[:, :3, :3], compute_uv=False)
    # never by the determinant: a sound skeleton in units of 1e-4 has one of 1e-12
    singular = sizes[:, 2] <= 1e-7 * sizes[:, 0]
    if singular.any():
        names = ", ".join(repr(mesh.skeleton.names[i]) for i in np.flatnonzero(singular)[:3].tolist())
        findings.warn(
            "number.bind", f"{name}: {_count(singular)} joints have a flat bind pose ({names})",
            f"{path}.skeleton.inverse_bind", "reset the joints' scale in the bind pose; their vertices collapse",
        )  # fmt: skip


def _rows_not_finite(values: NDArray[Any]) -> NDArray[np.bool_]:
    return np.asarray(~np.isfinite(values).all(axis=1))


def _count(flags: NDArray[np.bool_]) -> str:
    return f"{np.count_nonzero(flags):,}"
