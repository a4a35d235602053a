"""What the open scene is made of and what it takes: meshes, textures, materials, memory, what is wrong. No imgui.

runtime (scene, residency) ──► asset_report ──► AssetReport ──► panels/asset_report, as_text for the clipboard
"""

from __future__ import annotations

from collections import Counter, defaultdict
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from engine.core.findings import Finding, Severity
from engine.framegraph.resources import human_bytes, texture_bytes


@dataclass(frozen=True, slots=True)
class MeshRow:
    """`bytes`: vertices and indices as the device holds them; `uses`: nodes that show it."""

    name: str
    mesh: int
    vertices: int
    triangles: int
    parts: int
    uses: int
    bytes: int
    streams: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TextureRow:
    """`bytes`: on the device, with mips; `disk`: of the file, 0 where there is none; `users`: "material: slot"."""

    name: str
    path: str
    format: str
    width: int
    height: int
    mips: int
    bytes: int
    disk: int
    users: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class MaterialRow:
    """`bytes`: of its textures, which others may share; `parts`: instances drawn with it."""

    name: str
    material: int
    effect: str
    textures: int
    bytes: int
    parts: int


@dataclass(frozen=True, slots=True)
class AssetReport:
    """`totals`: (what, amount as one reads it, what it means)."""

    totals: tuple[tuple[str, str, str], ...] = ()
    meshes: tuple[MeshRow, ...] = ()
    textures: tuple[TextureRow, ...] = ()
    materials: tuple[MaterialRow, ...] = ()
    findings: tuple[Finding, ...] = ()
    counts: dict[Severity, int] = field(default_factory=dict)


def asset_report(document: Any) -> AssetReport:
    """Of the document as it is now."""
    runtime = document.runtime
    residency, table = runtime.residency, runtime.scene.instances
    drawn = np.flatnonzero(table.alive)
    meshes = _meshes(residency, table, drawn)
    textures, of_material = _textures(residency, table, drawn)
    materials = _materials(residency, table, drawn, of_material)
    findings = list(document.findings)
    for found in getattr(runtime, "findings", None) or ():
        if found not in findings:
            findings.append(found)
    counts = Counter(f.severity for f in findings)
    triangles = sum(row.triangles * row.uses for row in meshes)
    vertex_bytes, texture_total = sum(m.bytes for m in meshes), sum(t.bytes for t in textures)
    totals = (
        ("Memory", human_bytes(vertex_bytes + texture_total), "Of the device, for meshes and textures of materials"),
        ("Meshes", f"{len(meshes):,}, {human_bytes(vertex_bytes)}", "Vertices and indices"),
        ("Triangles", f"{sum(m.triangles for m in meshes):,}, drawn {triangles:,}", "Of each mesh once; of every use"),
        ("Textures", f"{len(textures):,}, {human_bytes(texture_total)}", "With their mips, those of materials"),
        ("Materials", f"{len(materials):,}", "Those that something is drawn with"),
        ("Nodes", f"{runtime.scene.nodes.alive_count:,}", "All, shown or hidden"),
        ("On disk", human_bytes(_disk(document, textures)), "The scene's file and the textures it names"),
    )  # fmt: skip
    return AssetReport(totals, tuple(meshes), tuple(textures), tuple(materials), tuple(findings), dict(counts))


def _meshes(residency: Any, table: Any, drawn: Any) -> list[MeshRow]:
    nodes: dict[int, set[int]] = defaultdict(set)
    for row in drawn:
        nodes[int(table.mesh[row])].add(int(table.node[row]))
    rows = []
    for mesh, users in nodes.items():
        asset = residency.meshes[mesh].asset
        streams = getattr(asset, "streams", {})
        size = sum(int(values.nbytes) for values in streams.values()) + int(
            getattr(getattr(asset, "indices", None), "nbytes", 0)
        )
        triangles = sum(part.index_count // 3 for part in asset.submeshes if part.topology == "triangles")
        rows.append(
            MeshRow(
                asset.name or f"mesh {mesh}", mesh, asset.vertex_count, triangles, len(asset.submeshes), len(users),
                size, tuple(streams),
            )
        )  # fmt: skip
    return sorted(rows, key=lambda row: -row.bytes)


def _textures(residency: Any, table: Any, drawn: Any) -> tuple[list[TextureRow], dict[int, dict[str, int]]]:
    """The rows, and of each material the bytes of its textures by file."""
    store = getattr(residency, "materials", None)
    descs: dict[str, Any] = {}
    users: dict[str, list[str]] = defaultdict(list)
    of_material: dict[int, dict[str, int]] = defaultdict(dict)
    for material in dict.fromkeys(int(m) for m in table.material[drawn] if m >= 0):
        record = residency.material(material)
        for slot in record.effect.textures:
            ref = record.asset.textures.get(slot.name)
            if ref is None or not ref.path or store is None:
                continue
            path = str((getattr(record, "folder", Path()) / ref.path).resolve())
            if path not in descs:
                texture, _layer = store.slot_texture(material, slot.name)
                descs[path] = replace(texture.desc, layers=1)
            users[path].append(f"{record.asset.name or 'material'}: {slot.name.removesuffix('_map').replace('_', ' ')}")
            of_material[material][path] = texture_bytes(descs[path])
    rows = [
        TextureRow(
            Path(path).name, path, desc.format, desc.width, desc.height, desc.mips, texture_bytes(desc), _size(path),
            tuple(users[path]),
        )
        for path, desc in descs.items()
    ]  # fmt: skip
    return sorted(rows, key=lambda row: -row.bytes), of_material


def _materials(residency: Any, table: Any, drawn: Any, textures: dict[int, dict[str, int]]) -> list[MaterialRow]:
    parts = Counter(int(m) for m in table.material[drawn] if m >= 0)
    rows = []
    for material, count in parts.items():
        record, own = residency.material(material), textures.get(material, {})
        name = record.asset.name or f"material {material}"
        rows.append(MaterialRow(name, material, record.effect.name, len(own), sum(own.values()), count))
    return sorted(rows, key=lambda row: (-row.bytes, row.name))


def _size(path: str | Path) -> int:
    try:
        return Path(path).stat().st_size
    except OSError:
        return 0


def _disk(document: Any, textures: list[TextureRow]) -> int:
    source = document.source
    return (_size(source) if not source.is_dir() else _size(document.scene_path)) + sum(t.disk for t in textures)


def as_text(report: AssetReport, name: str) -> str:
    """All of it as lines of text, tables with tabs between their columns."""
    lines = [
        name,
        *(f"{what}\t{amount}" for what, amount, _doc in report.totals),
        "",
        "mesh\tvertices\ttriangles\tuses\tbytes",
    ]
    lines += [f"{m.name}\t{m.vertices}\t{m.triangles}\t{m.uses}\t{m.bytes}" for m in report.meshes]
    lines += ["", "texture\tformat\tsize\tmips\tbytes\tused by"]
    lines += [
        f"{t.name}\t{t.format}\t{t.width}x{t.height}\t{t.mips}\t{t.bytes}\t{', '.join(t.users)}"
        for t in report.textures
    ]
    lines += ["", "material\teffect\ttextures\tbytes\tparts"]
    lines += [f"{m.name}\t{m.effect}\t{m.textures}\t{m.bytes}\t{m.parts}" for m in report.materials]
    lines += ["", *(f"{f.severity.value}: {f.where}: {f.message}" for f in report.findings)]
    return "\n".join(lines)


def nodes_of(document: Any, *, mesh: int = -1, material: int = -1) -> list[int]:
    """The nodes that show that mesh, or wear that material."""
    table = document.runtime.scene.instances
    chosen = table.alive & ((table.mesh == mesh) if mesh >= 0 else (table.material == material))
    return sorted({int(node) for node in table.node[np.flatnonzero(chosen)]})
