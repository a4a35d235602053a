"""Real files, from source to picture: something is to be seen, nothing is magenta, and pruning changes no bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.core.paths import template_dir
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.metrics import is_blank
from importers.opening import open_path

FILES = (
    "DamagedHelmet/glTF-Binary/DamagedHelmet.glb",
    "Avocado/glTF/Avocado.gltf",
    "NormalTangentTest/glTF/NormalTangentTest.gltf",
    "TextureSettingsTest/glTF-Binary/TextureSettingsTest.glb",
    "BoxVertexColors/glTF-Binary/BoxVertexColors.glb",
    "Cameras/glTF/Cameras.gltf",
    "Duck/glTF-Binary/Duck.glb",
    "2CylinderEngine/glTF-Binary/2CylinderEngine.glb",
    "CesiumMilkTruck/glTF-Binary/CesiumMilkTruck.glb",
    "CesiumMan/glTF-Binary/CesiumMan.glb",
)


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))


def _check(device, path: Path) -> None:
    runtime = Runtime(device)
    try:
        findings = open_path(runtime, path)
        assert not findings.has_errors, [str(f) for f in findings]
        runtime.update(0.4)
        pictures = []
        for force_all in (False, True):
            settings = RenderSettings(samples=1, anisotropy=1.0, force_all=force_all)
            view = View(runtime.default_camera(1.5), 96, 64, settings)
            pictures.append(render_image(runtime, view)[0].copy())
        assert not runtime.renderer.programs.errors
        pruned, forced = pictures
        assert not is_blank(pruned[..., :3])
        magenta = (pruned[..., 0] > 200) & (pruned[..., 1] < 60) & (pruned[..., 2] > 200)
        assert magenta.mean() < 0.01
        assert np.array_equal(pruned, forced)
    finally:
        runtime.close()


@pytest.mark.parametrize("name", FILES, ids=lambda name: Path(name).stem)
def test_sample_file(gl_device, shared_assets, name) -> None:
    _check(gl_device, shared_assets / "gltf" / name)


def test_our_own_sample(gl_device) -> None:
    _check(gl_device, template_dir() / "assets" / "orrery.glb")
