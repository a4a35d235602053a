"""Materials as arrays, and what a surface is where a ray hits it: textures, normal maps, alpha."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.core.errors import InputError
from engine.experiments.truth.rays import Hits
from engine.experiments.truth.texels import Lookup, TextureFiles
from engine.experiments.truth.triangles import Triangles
from engine.gpu.types import Device
from engine.resources.material_store import MaterialRecord
from engine.resources.residency import Residency

F8 = NDArray[np.float64]

OPAQUE, CUT, BLENDED = 0, 1, 2
_MODES = {"alpha_test": CUT, "transparent": BLENDED, "overlay": BLENDED}
_VALUES = ("metallic", "roughness", "emissive_strength", "normal_scale", "alpha_cutoff", "ior", "specular")


@dataclass(slots=True)
class Materials:
    """Every value by material id: `values` name -> f8[m], colours f8[m,3|4]; `lookups` (material, slot)."""

    values: dict[str, F8]
    base: F8
    emissive: F8
    specular_color: F8
    mode: NDArray[np.int8]
    unlit: NDArray[np.bool_]
    double_sided: NDArray[np.bool_]
    lookups: dict[tuple[int, str], Lookup] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


@dataclass(slots=True)
class Surface:
    """n places: `place`, `face` (of the triangle) and `normal` (as shaded), towards the ray's side; values [n] and
    colours [n,3] as the standard surface has them; `glow`: what it emits; `front`: whether the front was hit."""

    place: F8
    face: F8
    normal: F8
    base: F8
    alpha: F8
    metallic: F8
    roughness: F8
    glow: F8
    f0: F8
    f90: F8
    unlit: NDArray[np.bool_]
    front: NDArray[np.bool_]

    @property
    def albedo(self) -> F8:
        """Of the diffuse part."""
        return self.base * (1.0 - self.metallic[:, None])


def materials_of(residency: Residency, device: Device, used: NDArray[np.integer]) -> Materials:
    """The materials `used` of a residency. What is not the standard surface is taken for it, and `notes` say so."""
    records = residency.materials.records
    count = len(records)
    found = Materials(
        {name: np.zeros(count) for name in _VALUES}, np.ones((count, 4)), np.zeros((count, 3)), np.ones((count, 3)),
        np.zeros(count, np.int8), np.zeros(count, bool), np.zeros(count, bool),
    )  # fmt: skip
    files = TextureFiles(device)
    for i in np.unique(used).tolist():
        record = records[i]
        asset = record.asset
        for name in _VALUES:
            found.values[name][i] = _param(record, name, 0.0)
        found.base[i] = _param(record, "base_color", (1.0,) * 4)
        found.emissive[i] = _param(record, "emissive", (0.0,) * 3)
        found.specular_color[i] = _param(record, "specular_color", (1.0,) * 3)
        found.mode[i] = _MODES.get(asset.queue, OPAQUE)
        found.unlit[i] = "unlit" in asset.features
        found.double_sided[i] = "double_sided" in asset.features
        if record.effect.name != "surface":
            found.notes.append(f"material {asset.name}: effect {record.effect.name} is taken as the standard surface")
        for slot, ref in asset.textures.items():
            try:
                found.lookups[i, slot] = files.lookup(ref, record.folder)
            except (InputError, OSError) as error:
                found.notes.append(f"material {asset.name}, {slot}: {error}")
    return found


def _param(record: MaterialRecord, name: str, fallback: Any) -> Any:
    default = next((p.default for p in record.effect.params if p.name == name), fallback)
    return record.asset.params.get(name, default)


def surface_at(triangles: Triangles, materials: Materials, hits: Hits, rows: NDArray[np.int64], d: F8) -> Surface:
    """What the rays `rows` of `hits` met (all of them met something), travelling along `d` [len(rows),3]."""
    t = hits.triangle[rows]
    w = np.stack([1.0 - hits.u[rows] - hits.v[rows], hits.u[rows], hits.v[rows]], axis=1)
    material = triangles.material[t]
    place = np.einsum("nk,nkj->nj", w, triangles.corners[t])
    face = triangles.face[t]
    normal = _unit(np.einsum("nk,nkj->nj", w, triangles.normals[t]), face)
    uv = [np.einsum("nk,nkj->nj", w, part[t]) for part in (triangles.uv0, triangles.uv1)]
    base = materials.base[material].copy()
    values = {name: column[material].copy() for name, column in materials.values.items()}
    glow = materials.emissive[material] * values["emissive_strength"][:, None]
    base *= np.einsum("nk,nkj->nj", w, triangles.colors[t])
    for (i, slot), lookup in materials.lookups.items():
        at = np.flatnonzero(material == i)
        if at.size == 0:
            continue
        texel = lookup(uv[1 if lookup.uv_set else 0][at])
        if slot == "base_color_map":
            base[at] *= texel
        elif slot == "metal_rough_map":
            values["roughness"][at] *= texel[:, 1]
            values["metallic"][at] *= texel[:, 2]
        elif slot == "emissive_map":
            glow[at] *= texel[:, :3]
        elif slot == "normal_map":
            tangent = np.einsum("nk,nkj->nj", w[at], triangles.tangents[t[at]])
            normal[at] = _bent(normal[at], tangent, texel[:, :2] * 2.0 - 1.0, values["normal_scale"][at])
    front = np.einsum("ij,ij->i", face, d) < 0.0
    side = np.where(front, 1.0, -1.0)[:, None]
    dielectric = ((values["ior"] - 1.0) / (values["ior"] + 1.0)) ** 2
    f0 = np.minimum(dielectric[:, None] * materials.specular_color[material], 1.0) * values["specular"][:, None]
    metal = values["metallic"][:, None]
    return Surface(
        place, face * side, normal * side, base[:, :3], base[:, 3], values["metallic"], values["roughness"], glow,
        f0 + (base[:, :3] - f0) * metal, values["specular"] + (1.0 - values["specular"]) * values["metallic"],
        materials.unlit[material], front,
    )  # fmt: skip


def passes_through(triangles: Triangles, materials: Materials, hits: Hits, u: F8) -> NDArray[np.bool_]:
    """Which rays go on through what they met: cut-out holes, and blended surfaces by the chance of their alpha
    (`u` [n] in [0, 1))."""
    out = np.zeros(len(hits.triangle), bool)
    met = hits.triangle >= 0
    mode = np.zeros(len(out), np.int8)
    mode[met] = materials.mode[triangles.material[hits.triangle[met]]]
    rows = np.flatnonzero(mode != OPAQUE)
    if rows.size:
        alpha = surface_at(triangles, materials, hits, rows, np.zeros((len(rows), 3))).alpha
        cutoff = materials.values["alpha_cutoff"][triangles.material[hits.triangle[rows]]]
        out[rows] = np.where(mode[rows] == CUT, alpha < cutoff, u[rows] >= alpha)
    return out


def _bent(n: F8, tangent: F8, xy: F8, scale: F8) -> F8:
    """Mikkelsen 2008: the map's x and y along tangent and bitangent, z rebuilt; as the shader does it."""
    z = np.sqrt(np.maximum(1.0 - np.einsum("ij,ij->i", xy, xy), 0.0))
    t = _unit(tangent[:, :3], np.zeros_like(n))
    b = np.cross(n, t) * np.sign(tangent[:, 3:])
    return _unit(scale[:, None] * (xy[:, :1] * t + xy[:, 1:] * b) + z[:, None] * n, n)


def _unit(v: F8, fallback: F8) -> F8:
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.where(length > 1e-20, v / np.maximum(length, 1e-20), fallback)
