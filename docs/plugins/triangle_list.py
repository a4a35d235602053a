"""An importer: `*.triangles`, text with the nine numbers of a triangle in each line (metres, +Y up)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from editor.plugins.api import Plugin
from engine.assets.mesh import MeshAsset, Submesh
from engine.assets.scene import MeshRef, NodeAsset
from engine.core.errors import FormatError, Place
from engine.core.findings import Findings
from importers.model import ImportedModel
from importers.registry import Importer
from importers.settings import ImportSettings

# `module` is this file; the plug-in fills it in
IMPORTER = Importer("triangles", __name__, (".triangles",), 1, lambda head: False)


def load(path: Path, settings: ImportSettings) -> ImportedModel:
    corners = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        words = line.split("#")[0].split()
        try:
            values = [float(word) for word in words]
        except ValueError:
            raise FormatError("a number was expected", where=Place(str(path), line=number)) from None
        if len(values) not in (0, 9):
            raise FormatError(f"{len(values)} numbers, and a triangle has nine", where=Place(str(path), line=number))
        corners += values
    if not corners:
        raise FormatError("there is no triangle", where=path)
    position = np.array(corners, np.float32).reshape(-1, 3)
    sides = position.reshape(-1, 3, 3)
    flat = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-30)
    normal = np.zeros((len(position), 4), np.int16)
    normal[:, :3] = np.rint(np.repeat(flat, 3, axis=0) * 32767)
    low, high = position.min(axis=0).tolist(), position.max(axis=0).tolist()
    part = Submesh(0, len(position), 0, "triangles", tuple(low), tuple(high))
    mesh = MeshAsset(
        path.stem, {"position": position, "normal": normal}, np.arange(len(position), dtype=np.uint32), [part]
    )
    node = NodeAsset(path.stem, mesh=MeshRef("", 0, path.stem))
    return ImportedModel(path.stem, Findings(str(path)), [mesh], [[-1]], nodes=[node])


def dependencies(path: Path, settings: ImportSettings) -> list[tuple[str, Path]]:
    return []


def register(plugin: Plugin) -> None:
    plugin.importer(IMPORTER)
