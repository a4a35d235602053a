"""What is done alike to the models of all formats, by the settings of the groups geometry and animation.

    importer.load ─> clean ─> ImportedModel ─> finish: keys reduced ─> LODs ─> triangles and vertices in order ─> files
                     (triangles twice or collapsed)                             (quantised when written: engine.assets)

`clean` comes with every load, so that whatever looks at a source sees what will be written; `finish` only where files
are. What was done is a finding, with the error that it costs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.assets.mesh import MeshAsset, MorphTarget, Submesh
from engine.assets.quantized import error
from importers.geometry.vertex_order import cache_order, fetch_order, outermost_first
from importers.model import ImportedModel
from importers.settings import ImportSettings

Triangles = NDArray[np.uint32]


def clean(model: ImportedModel, settings: ImportSettings) -> None:
    """Leave out triangles that name a vertex twice, and those that a submesh has twice."""
    if not settings.clean_triangles:
        return
    for mesh in model.meshes:
        runs: list[NDArray[np.uint32]] = []
        collapsed = doubled = 0
        for part in mesh.submeshes:
            run = mesh.indices[part.first_index : part.first_index + part.index_count]
            if part.topology == "triangles" and len(run):
                triangles = run.reshape(-1, 3)
                a, b, c = triangles.T
                good = (a != b) & (b != c) & (c != a)
                collapsed += int((~good).sum())
                again = _again(triangles) & good
                doubled += int(again.sum())
                run = triangles[good & ~again].reshape(-1)
            runs.append(run)
        where = f"meshes[{mesh.name}]"
        if collapsed:
            model.findings.info("mesh.collapsed", f"{collapsed:,} triangles name a vertex twice; left out", where)
        if doubled:
            model.findings.info("mesh.doubled", f"{doubled:,} triangles are there twice; left out", where)
        if collapsed or doubled:
            _set_runs(mesh, runs)


def finish(model: ImportedModel, settings: ImportSettings) -> None:
    """Reduce keys, add levels of detail, and order triangles and vertices; in place."""
    if settings.key_error_mm != 0.0 and model.clips:
        from importers.key_reduction import reduce_model

        reduce_model(model, settings.key_error_mm / 1000.0)
    if settings.lods:
        from importers.lods import add_lods

        add_lods(model, settings.lods)
    if settings.triangle_order != "source":
        for mesh in model.meshes:
            order_mesh(mesh, overdraw=settings.triangle_order == "overdraw")
    if settings.quantize:
        for mesh in model.meshes:
            mesh.extras["quantize"] = True
            streams = {"position": mesh.streams["position"]} | {
                f"{m.name}.position": m.streams["position"] for m in mesh.morphs if "position" in m.streams
            }
            off = {name: 1000.0 * error(values) for name, values in streams.items()}
            uv = max((error(mesh.streams[n]) for n in ("uv0", "uv1") if n in mesh.streams), default=0.0)
            worst = max(off, key=lambda name: off[name])
            model.findings.info(
                "mesh.quantized", f"positions are off by {off[worst]:.3g} mm at most ({worst}), uvs by {uv:.2g}",
                f"meshes[{mesh.name}]",
            )  # fmt: skip


def order_mesh(mesh: MeshAsset, *, overdraw: bool) -> None:
    """Triangles in vertex-cache order, with `overdraw` in runs from the outside in; vertices in the order of use."""
    position = np.asarray(mesh.streams["position"], np.float32)
    indices = mesh.indices.copy()
    for part in mesh.submeshes:
        if part.topology != "triangles" or part.index_count < 6:
            continue
        run = slice(part.first_index, part.first_index + part.index_count)
        triangles = indices[run].reshape(-1, 3)
        order, begins = cache_order(triangles)
        triangles = triangles[order]
        if overdraw and len(begins) > 1:
            triangles = triangles[outermost_first(position, triangles, begins)]
        indices[run] = triangles.reshape(-1)
    gather_vertices(mesh, fetch_order(indices, mesh.vertex_count), indices)


def gather_vertices(mesh: MeshAsset, source: NDArray[np.int64], indices: NDArray[np.uint32]) -> None:
    """Number the vertices anew: `source` i8[n] names the old vertex of each new one; `indices` are the old ones'."""
    place = np.zeros(mesh.vertex_count, np.uint32)
    place[source] = np.arange(len(source), dtype=np.uint32)
    mesh.indices = np.ascontiguousarray(place[indices])
    count = mesh.vertex_count
    mesh.streams = {name: np.ascontiguousarray(values[source]) for name, values in mesh.streams.items()}
    mesh.morphs = [
        MorphTarget(m.name, {name: np.ascontiguousarray(values[source]) for name, values in m.streams.items()})
        for m in mesh.morphs
    ]
    share = mesh.extras.get("dual_quaternion_share")
    if isinstance(share, list) and len(share) == count:
        mesh.extras["dual_quaternion_share"] = [share[i] for i in source.tolist()]


def _again(triangles: Triangles) -> NDArray[np.bool_]:
    """bool[t]: whether an earlier triangle has the same corners in the same sense."""
    first = np.argmin(triangles, axis=1)
    rows = np.arange(len(triangles))[:, None]
    turned = triangles[rows, (first[:, None] + np.arange(3)) % 3].astype(np.uint32)
    keys = np.ascontiguousarray(turned).view(np.dtype((np.void, 12))).reshape(-1)
    _, number = np.unique(keys, return_index=True)
    again = np.ones(len(triangles), bool)
    again[number] = False
    return again


def _set_runs(mesh: MeshAsset, runs: list[NDArray[np.uint32]]) -> None:
    """Give every submesh its new run of indices; those left empty keep their place with none."""
    first = 0
    parts: list[Submesh] = []
    for part, run in zip(mesh.submeshes, runs, strict=True):
        parts.append(Submesh(first, len(run), part.material_slot, part.topology, part.bounds_min, part.bounds_max))
        first += len(run)
    mesh.submeshes = parts
    mesh.indices = np.ascontiguousarray(np.concatenate(runs).astype("<u4")) if runs else mesh.indices
