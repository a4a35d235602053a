"""Plug-ins: each of the four kinds does its work, is taken back, and failing costs nothing but itself."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from animated_scene import NullHost
from small_scene import write_small_scene

from editor.builtin_operations import builtin_operations
from editor.document import Document
from editor.host import Resolved
from editor.plugins.manager import Loaded, PluginManager
from editor.preferences import Preferences
from editor.session import Session
from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.gpu.types import Device
from engine.materials.library import EXTRA_FOLDERS
from engine.render.extra_passes import EXTRA
from engine.render.settings import RenderSettings
from engine.render.view import View

EXAMPLES = Path(__file__).resolve().parents[2] / "docs" / "plugins"


@pytest.fixture
def project(tmp_path: Path) -> Path:
    (tmp_path / "plugins").mkdir()
    write_small_scene(tmp_path)
    return tmp_path


@pytest.fixture
def manager(project: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[PluginManager]:
    monkeypatch.setenv("LUCARNA_IMPORTERS", "")
    host = NullHost.__new__(NullHost)
    session = Session(host, Preferences())
    session.save_preferences = False
    session.device = host.open_device(False)
    scene = project / "boxes.scene.json"
    session.adopt(Document(Resolved(scene, scene, project, "project"), host.open_runtime(session.device, scene)))
    made = PluginManager(session, builtin_operations())
    yield made
    made.enter(None)
    session.close()
    assert not EXTRA.make()
    assert not EXTRA_FOLDERS


def use(manager: PluginManager, example: str) -> Loaded:
    """Put an example into the project, and let it run."""
    assert manager.session.document is not None
    assert manager.session.document.project_root is not None
    source, folder = EXAMPLES / example, manager.session.document.project_root / "plugins"
    (shutil.copytree if source.is_dir() else shutil.copy)(source, folder / example)
    manager.poll()
    manager.trust(always=False)
    return manager.plugins[0]


def write(manager: PluginManager, text: str, at: float = 1.0) -> Path:
    assert manager.session.document is not None
    assert manager.session.document.project_root is not None
    path = manager.session.document.project_root / "plugins" / "own.py"
    path.write_text(text, encoding="utf-8")
    os.utime(path, (at, at))
    return path


def test_nothing_of_a_project_runs_before_the_user_says_so(manager: PluginManager) -> None:
    write(manager, "raise SystemError('ran')")
    manager.poll()
    (plugin,) = manager.plugins
    assert (plugin.state, manager.asking) == ("waits", manager.root)
    manager.decline()
    manager.look()
    assert (plugin.state, manager.asking) == ("waits", None)
    manager.trust()
    assert plugin.state == "failed"
    assert manager.session.preferences.trusted_projects == [str(manager.root.resolve())]  # type: ignore[union-attr]  # the manager of these tests has a session


def test_without_plugins_nothing_is_looked_for(manager: PluginManager) -> None:
    write(manager, "raise SystemError('ran')")
    manager.active = False
    manager.poll()
    assert not manager.plugins


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("def register(plugin):\n    x = 1\n    1 / 0\n", 3),
        ("def register(plugin):\n    plugin.operation('edit.undo', 'Undo', print)\n", 2),
        ("def register(:\n", 1),
        ("import nothing_of_that_name\n", 1),
    ],
)
def test_a_broken_one_is_listed_with_its_line_and_the_rest_goes_on(
    manager: PluginManager, text: str, line: int
) -> None:
    path = write(manager, text)
    manager.poll()
    manager.trust(always=False)
    (plugin,) = manager.plugins
    assert plugin.state == "failed"
    assert plugin.error.startswith(f"{path}:{line}: ")
    assert manager.operations.run("edit.select-all", manager.session)
    write(manager, "def register(plugin):\n    plugin.operation('own.hello', 'Hello', lambda session: None)\n", at=2.0)
    manager.look()
    assert plugin.state == "on"
    assert "own.hello" in manager.operations


def test_what_failed_half_way_is_taken_back(manager: PluginManager) -> None:
    write(manager, "def register(plugin):\n    plugin.operation('own.a', 'A', print)\n    1 / 0\n")
    manager.poll()
    manager.trust(always=False)
    assert "own.a" not in manager.operations


def test_an_operation_that_raises_switches_its_plugin_off(manager: PluginManager) -> None:
    path = write(
        manager, "def run(session):\n    [][1]\n\ndef register(plugin):\n    plugin.operation('own.a', 'A', run)\n"
    )
    manager.poll()
    manager.trust(always=False)
    assert manager.operations.run("own.a", manager.session)
    assert manager.plugins[0].error.startswith(f"{path}:2: IndexError")
    assert "own.a" not in manager.operations


def test_a_changed_file_is_loaded_again(manager: PluginManager) -> None:
    text = "def register(plugin):\n    plugin.operation('own.{0}', 'A', print)\n"
    write(manager, text.format("one"))
    manager.poll()
    manager.trust(always=False)
    write(manager, text.format("two"), at=2.0)
    manager.look()
    assert "own.two" in manager.operations
    assert "own.one" not in manager.operations


def test_example_panel_and_operation(manager: PluginManager) -> None:
    pytest.importorskip("imgui_bundle")
    plugin = use(manager, "node_counter.py")
    assert plugin.state == "on", plugin.error
    assert [w.panel.title for w in manager.windows] == ["Node counter"]
    assert manager.operations.run("node-counter.select", manager.session, kind="cube")
    assert manager.session.document is not None
    assert manager.session.document.selection == (2,)
    manager.set_wanted(plugin, False)
    assert not manager.windows
    assert "plugin.show-node-counter" not in manager.operations


def test_example_importer(manager: PluginManager, project: Path) -> None:
    from importers.convert import convert
    from importers.registry import find_importer
    from importers.settings import ImportSettings

    plugin = use(manager, "triangle_list.py")
    assert plugin.state == "on", plugin.error
    source = project / "roof.triangles"
    source.write_text("0 0 0  1 0 0  0 1 0  # one\n\n0 0 1  1 0 1  0 1 1\n")
    assert find_importer(source).name == "triangles"
    result = convert(source, project / "out", ImportSettings())
    runtime = Runtime(manager.session.device)
    assert result.scene is not None
    runtime.open(result.scene)
    assert runtime.residency.meshes[0].asset.vertex_count == 6
    runtime.close()
    source.write_text("0 0 0  1 0 0  0 1\n")
    with pytest.raises(Exception, match=r"roof\.triangles:1: 8 numbers"):
        convert(source, project / "out", ImportSettings())


def picture(device: Device, scene: Path) -> np.ndarray:
    runtime = Runtime(device)
    runtime.open(scene)
    try:
        camera = runtime.default_camera(64 / 48)
        return render_image(runtime, View(camera, 64, 48, RenderSettings(samples=1)))[0].astype(np.float64)
    finally:
        runtime.close()


def test_example_pass(manager: PluginManager, gl_device: Device, project: Path) -> None:
    scene = project / "boxes.scene.json"
    before = picture(gl_device, scene)
    plugin = use(manager, "vignette")
    assert plugin.state == "on", plugin.error
    after = picture(gl_device, scene)
    assert before[0, 0, :3].min() > 20, "the corner shows something"
    np.testing.assert_allclose(after[24, 32], before[24, 32], atol=1.0)
    assert np.all(after[0, 0, :3] < 0.35 * before[0, 0, :3])
    EXTRA.params["vignette"].strength = 0.0
    np.testing.assert_array_equal(picture(gl_device, scene), before)
    manager.set_wanted(plugin, False)
    np.testing.assert_array_equal(picture(gl_device, scene), before)


def test_a_pass_that_raises_is_taken_out(manager: PluginManager, gl_device: Device, project: Path) -> None:
    scene = project / "boxes.scene.json"
    before = picture(gl_device, scene)
    path = write(
        manager,
        "from engine.render.screen_pass import ScreenPass\n\nclass Bad(ScreenPass):\n    name = 'bad'\n\n"
        "    def execute(self, ctx):\n        raise ValueError('no')\n\n"
        "def register(plugin):\n    plugin.render_pass(Bad)\n",
    )
    manager.poll()
    manager.trust(always=False)
    np.testing.assert_array_equal(picture(gl_device, scene), before)
    assert manager.plugins[0].error == f"{path}:7: ValueError: no"
    assert not EXTRA.make()


def test_example_effect(manager: PluginManager) -> None:
    plugin = use(manager, "stripes")
    assert plugin.state == "on", plugin.error
    assert manager.session.document is not None
    library = manager.session.document.runtime.residency.effects
    assert library.get("stripes").param("repeats").default == 8.0
