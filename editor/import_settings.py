"""How the source of the document in front is imported: read, changed in its sidecar, and imported again. No imgui."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from editor import reimporting
from editor.commands.replacement import settled
from engine.core.errors import LucarnaError

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session
    from importers.settings import ImportSettings


@dataclass(frozen=True, slots=True)
class Fix:
    """A button of the import card. `value`: what the setting becomes, or for a `factor` what it is multiplied by;
    where it has that value already, the fix takes it away again."""

    id: str
    label: str
    setting: str
    value: Any
    doc: str
    factor: bool = False


FIXES = (
    Fix("scale-down", "× 0.01", "scale", 0.01, "The source is in centimetres but says metres", factor=True),
    Fix("scale-up", "× 100", "scale", 100.0, "The source is in metres but says centimetres", factor=True),
    Fix("z-up", "Z up → Y up", "turn", "z-up", "The source's Z axis is up, though it does not say so"),
    Fix("turn-back", "Front ↔ back", "turn", "back", "Turn it to look the other way"),
    Fix("flip-v", "Flip V", "flip_v", True, "Texture coordinates are upside down"),
    Fix("two-sided", "Two-sided", "two_sided", True, "Faces are seen from their backs, too"),
    Fix("smooth", "Smooth normals", "normals", "smooth", "Make normals anew, smooth over flat edges"),
    Fix("flat", "Flat normals", "normals", "flat", "Make normals anew, one a face"),
    Fix("tangents", "New tangents", "tangents", True, "Make tangents anew from the texture coordinates"),
    Fix("flip-green", "Flip green", "flip_green", True, "Normal maps have +Y down, as DirectX wants them"),
)


def can_import(session: Session) -> bool:
    document = session.document
    return document is not None and document.imported_from is not None and document.imported_from.is_file()


def settings_of(source: Path) -> ImportSettings:
    """The settings that `source` is imported with: sidecar, preset and project have their say. Raises LucarnaError."""
    from importers.presets import resolve

    return resolve(source).settings


def is_on(settings: ImportSettings, fix: Fix) -> bool:
    return not fix.factor and getattr(settings, fix.setting) == fix.value


def apply_fix(session: Session, fix: Fix) -> None:
    """Do what the fix's button says: one undoable entry, remembered in the source's sidecar."""
    source = session.document.imported_from if session.document is not None else None
    if source is None:
        return
    try:
        settings = settings_of(source)
    except LucarnaError as error:
        session.fail(error)
        return
    value = fix.value
    if fix.factor:
        value = float(f"{getattr(settings, fix.setting) * fix.value:.12g}")
    elif is_on(settings, fix):
        value = None
    change(session, {fix.setting: value}, f"Import {source.name}: {fix.label}")


def change(session: Session, changes: Mapping[str, Any], label: str = "") -> bool:
    """Set import settings of the source in its sidecar (None: as by default) and import it again. False where it was
    refused; then the sidecar is as it was."""
    from importers.presets import save_sidecar, sidecar_path

    source = session.document.imported_from if session.document is not None else None
    if source is None:
        return False
    path = sidecar_path(source)
    before = path.read_text("utf-8") if path.is_file() else ""
    try:
        save_sidecar(source, changes)
    except LucarnaError as error:
        session.fail(error)
        return False
    after = path.read_text("utf-8") if path.is_file() else ""
    label = label or f"Import {source.name} with {', '.join(changes)}"
    return reimporting.start(session, label, (settled(after, path), settled(before, path)))


def facts(document: Document) -> dict[str, str]:
    """What the card says of the imported scene, in words."""
    scene, residency = document.runtime.scene, document.runtime.residency
    low, high = document.bounds()
    size = high - low
    told: dict[str, str] = {}
    if np.isfinite(size).all():
        told["Size"] = f"{_metres(size[0])} × {_metres(size[1])} × {_metres(size[2])} m (x, y up, z)"
        told["As large as"] = as_large_as(float(size.max()))
    table = scene.instances
    drawn = np.flatnonzero(table.alive)
    triangles = sum(
        residency.meshes[int(table.mesh[i])].asset.submeshes[int(table.submesh[i])].index_count // 3 for i in drawn
    )
    told["Nodes"] = f"{scene.nodes.alive_count:,}"
    told["Parts"] = f"{len(drawn):,} drawn, {triangles:,} triangles"
    told["Materials"] = f"{len(set(table.material[drawn].tolist())):,}"
    clips = len(getattr(document.runtime, "clips", ()))
    if clips:
        told["Clips"] = f"{clips}, the longest {float(document.runtime.duration):.2f} s"
    return told


def as_large_as(largest: float) -> str:
    """A thing of everyday of about that size, and of that alone: what tells wrong units at a glance."""
    for limit, what in (
        (1e-3, "a grain of sand: too small?"), (0.02, "a coin: too small?"), (0.3, "a cup"), (1.2, "a chair"),
        (2.6, "a door"), (8.0, "a car"), (40.0, "a house"), (400.0, "a street"),
    ):  # fmt: skip
        if largest < limit:
            return what
    return "a town: too large?"


def _metres(value: float) -> str:
    return f"{value:.3g}" if value < 100.0 else f"{value:,.0f}"
