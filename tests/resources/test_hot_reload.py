"""Hot reload of effects, includes, pass shaders and material files, on a scene with real pictures."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.app.framing import frame_bounds
from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.assets.lmesh import write_lmesh
from engine.assets.material import MaterialAsset
from engine.assets.material_toml import update_material, write_material
from engine.assets.primitives import cube
from engine.assets.scene import EnvironmentAsset, MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.errors import LucarnaError
from engine.core.paths import shaders_dir
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.resources.hot_reload import Reloaded

MATERIAL = "paint.material.toml"


class Project:
    """A scene of one cube with its own copy of the shaders, open and drawn."""

    def __init__(self, device: Device, folder: Path, effect: str = "surface") -> None:
        self.folder = folder
        shutil.copytree(shaders_dir(), folder / "shaders")
        write_lmesh(folder / "a.lmesh", [cube()], {})
        params = {"base_color": (0.8, 0.2, 0.1, 1.0), "metallic": 0.0, "roughness": 0.4}
        write_material(folder / MATERIAL, MaterialAsset("paint", effect, params=params))
        node = NodeAsset("cube", mesh=MeshRef("a.lmesh", 0, "cube", [MATERIAL]))
        look = EnvironmentAsset("uniform", color=(0.7, 0.7, 0.7), background="color", sun_illuminance=0.0)
        write_scene(folder / "a.scene.json", SceneAsset("a", [node], environment=look))
        self.runtime = Runtime(device, profile=False)
        self.runtime.open(folder / "a.scene.json")
        camera = frame_bounds(np.full(3, -0.5), np.full(3, 0.5), 1.0)
        self.view = View(camera, 48, 48, RenderSettings(samples=1))
        self.clock = 0.0

    def picture(self, **settings: Any) -> NDArray[np.uint8]:
        view = View(self.view.camera, 48, 48, RenderSettings(**{"samples": 1, **settings}))
        return np.array(render_image(self.runtime, view)[0])

    def edit(self, file: str, old: str, new: str) -> None:
        path = self.folder / file
        text = path.read_text(encoding="utf-8")
        assert old in text
        self.write(file, text.replace(old, new, 1))

    def write(self, file: str, text: str) -> None:
        path = self.folder / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        info = path.stat()
        os.utime(path, ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))

    def poll(self) -> Reloaded | None:
        self.clock += 1.0
        return self.runtime.hot_reload.poll(self.clock)

    def value(self, name: str) -> Any:
        return self.runtime.residency.materials.get_param(0, name)

    @property
    def problems(self) -> tuple[LucarnaError, ...]:
        return self.runtime.hot_reload.problems


@pytest.fixture
def project(gl_device: Device, tmp_path: Path) -> Iterator[Project]:
    made = Project(gl_device, tmp_path)
    yield made
    made.runtime.close()


FRAG, EFFECT, INCLUDE, TONE = (
    "shaders/effects/surface.frag", "shaders/effects/surface.effect.toml", "shaders/lib/brdf.glsl",
    "shaders/passes/tone_map.frag",
)  # fmt: skip
LAST = "sanitise(color), 1.0)"
SOURCES = (".glsl", ".vert", ".frag", ".comp", ".toml")


def test_an_edited_shader_is_on_screen_after_one_look(project: Project) -> None:
    before = project.picture()
    assert project.poll() is None
    project.edit(FRAG, LAST, "sanitise(color.bgr), 1.0)")
    result = project.poll()
    assert result is not None
    assert result.effects == ("surface",)
    assert result.problems == ()
    after = project.picture()
    assert (after[24, 24, 0], after[24, 24, 2]) == (before[24, 24, 2], before[24, 24, 0])
    assert project.poll() is None
    project.edit(FRAG, "sanitise(color.bgr), 1.0)", LAST)
    project.poll()
    np.testing.assert_array_equal(project.picture(), before)


@pytest.mark.parametrize(
    ("file", "old", "new", "named"),
    [
        (FRAG, LAST, "sanitise(color), 1.0", "surface.frag"),
        (FRAG, "vec3 color = shade(", "float color = shade(", "surface.frag"),
        (FRAG, "lib/view.glsl", "lib/veiw.glsl", "surface.frag:9:10"),
        (INCLUDE, "\n\n", '\n#include "lib/lights.glsl"\n', "brdf.glsl"),
        (EFFECT, "doc = ", "dok = ", "surface.effect.toml:3:1"),
        (EFFECT, 'fragment = "effects/surface.frag"', 'fragment = "effects/sruface.frag"', "surface.effect.toml"),
        (TONE, "void main()", "void main() {", "tone_map.frag"),
        (MATERIAL, "roughness", "roughnes", "paint.material.toml:8:1"),
        (MATERIAL, "metallic = 0.0", "metallic = [", "paint.material.toml"),
        (MATERIAL, "metallic = 0.0", "metallic = 7.0", "paint.material.toml"),
    ],
)
def test_a_mistake_keeps_the_picture_and_is_named_until_it_is_gone(
    project: Project, file: str, old: str, new: str, named: str
) -> None:
    before = project.picture()
    project.runtime.residency.set_material_param(0, "roughness", 0.9)
    rough = project.picture()
    assert (rough != before).any()
    project.edit(file, old, new)
    result = project.poll()
    assert result is not None
    assert result.names == []
    assert named in str(result.problems[0].where), result.problems[0]
    np.testing.assert_array_equal(project.picture(), rough)
    assert project.poll() is None
    assert project.problems == result.problems
    project.edit(file, new, old)
    assert project.poll() is not None
    assert project.problems == ()
    np.testing.assert_array_equal(project.picture(), rough)


def test_what_was_not_drawn_yet_is_drawn_from_the_last_good_files(project: Project) -> None:
    """A debug view switched on, and a sample count raised, while the files are broken."""
    for file in (FRAG, TONE):
        project.edit(file, "void main()", "void main( {")
    project.picture()
    project.poll()
    # no good version of its own was ever seen: the surface is magenta, the pass is the built-in one
    assert sorted(Path(p.where.file).name for p in project.problems) == ["surface.frag", "tone_map.frag"]
    for file in (FRAG, TONE):
        project.edit(file, "void main( {", "void main()")
    project.poll()
    lit, normal = project.picture(), project.picture(view="normal")
    project.edit(FRAG, "void main()", "void main( {")
    project.edit(TONE, "void main()", "void main( {")
    project.poll()
    assert len(project.problems) == 2
    rough = project.picture(view="roughness")
    assert (rough != lit).any()
    assert not (rough[24, 24, :3] == (255, 0, 255)).all()
    np.testing.assert_array_equal(project.picture(view="normal"), normal)
    np.testing.assert_array_equal(project.picture(), lit)
    project.picture(samples=4)


def test_parameters_outlive_a_new_layout(project: Project) -> None:
    project.picture()
    project.runtime.residency.set_material_param(0, "roughness", 0.75)
    project.edit(
        EFFECT, "[params.base_color]", '[params.aaa]\ntype = "vec3"\ndefault = [1.0, 2.0, 3.0]\n[params.base_color]'
    )
    result = project.poll()
    assert result is not None
    assert result.effects == ("surface",)
    assert project.value("roughness") == 0.75
    assert project.value("aaa") == (1.0, 2.0, 3.0)
    table = project.runtime.residency.materials._effects["surface"].table
    np.testing.assert_allclose(table.get_param(0, "base_color"), (0.8, 0.2, 0.1, 1.0), rtol=1e-6)
    np.testing.assert_allclose(table.get_param(0, "roughness"), 0.75)


def test_a_parameter_that_goes_and_comes_back_keeps_its_value(project: Project) -> None:
    before = project.picture()
    text = (project.folder / EFFECT).read_text(encoding="utf-8")
    project.write(EFFECT, text.replace("[params.roughness]", "[params.rough]"))
    project.edit(FRAG, "m.roughness;", "m.rough;")
    result = project.poll()
    assert result is not None
    assert result.effects == ("surface",)
    assert "did you mean 'rough'" in str(result.problems[0])
    assert f"{MATERIAL}:" in str(result.problems[0].where)
    assert (project.picture() != before).any()
    project.edit(FRAG, "m.rough;", "m.roughness;")
    project.write(EFFECT, text)
    project.poll()
    assert project.problems == ()
    np.testing.assert_array_equal(project.picture(), before)


def test_a_material_file_moves_values_features_and_queue(project: Project) -> None:
    before = project.picture()
    project.runtime.residency.set_material_param(0, "roughness", 0.9)
    update_material(project.folder / MATERIAL, {"params.base_color": (0.1, 0.2, 0.9, 1.0), "features": ["unlit"]})
    result = project.poll()
    assert result is not None
    assert result.materials == (project.folder / MATERIAL,)
    assert (project.picture() != before).any()
    assert project.value("base_color") == (0.1, 0.2, 0.9, 1.0)
    assert project.value("roughness") == 0.9, "set here and the same in the file: it stays"
    update_material(project.folder / MATERIAL, {"params.roughness": 0.1})
    project.poll()
    assert project.value("roughness") == 0.1, "set in the file after that"


def test_a_feature_whose_code_is_wrong_is_not_switched_on(project: Project) -> None:
    project.edit(FRAG, "#if UNLIT\n", "#if UNLIT\n    wrong;\n")
    before = project.picture()
    update_material(project.folder / MATERIAL, {"features": ["unlit"]})
    result = project.poll()
    assert result is not None
    assert "surface.frag" in str(result.problems[0].where)
    np.testing.assert_array_equal(project.picture(), before)
    project.edit(FRAG, "    wrong;\n", "")
    project.poll()
    assert project.problems == ()
    assert (project.picture() != before).any()


def test_a_material_that_never_was_good_comes_when_it_is(gl_device: Device, tmp_path: Path) -> None:
    project = Project(gl_device, tmp_path)
    try:
        project.edit(MATERIAL, 'effect = "surface"', 'effect = "surfaec"')
        project.runtime.open(tmp_path / "a.scene.json")
        magenta = project.picture()
        assert tuple(magenta[24, 24, :3]) == (255, 0, 255) or magenta[24, 24, 1] < 60
        assert "did you mean 'surface'" in str(project.problems[0])
        project.edit(MATERIAL, "surfaec", "surface")
        project.poll()
        assert project.problems == ()
        assert (project.picture() != magenta).any()
    finally:
        project.runtime.close()


def test_a_new_file_in_the_project_goes_before_the_built_in_one(gl_device: Device, tmp_path: Path) -> None:
    project = Project(gl_device, tmp_path)
    try:
        shutil.rmtree(tmp_path / "shaders")
        project.runtime.open(tmp_path / "a.scene.json")
        before = project.picture()
        text = (shaders_dir() / "effects/surface.frag").read_text(encoding="utf-8")
        project.write(FRAG, text.replace(LAST, "sanitise(color.bgr), 1.0)"))
        assert project.poll() is not None
        assert (project.picture() != before).any()
        tone = (shaders_dir() / "passes/tone_map.frag").read_text(encoding="utf-8")
        project.write(TONE, tone.replace("void main()", "void main( {"))
        project.poll()
        assert "tone_map.frag" in str(project.problems[0].where)
        shutil.rmtree(tmp_path / "shaders")
        project.poll()
        assert project.problems == ()
        np.testing.assert_array_equal(project.picture(), before)
    finally:
        project.runtime.close()


def test_nothing_is_looked_at_between_two_looks(project: Project) -> None:
    project.picture()
    reload = project.runtime.hot_reload
    assert not reload.changed(100.0)
    project.edit(FRAG, LAST, "sanitise(color.bgr), 1.0)")
    assert not reload.changed(100.2)
    assert reload.changed(100.3)
    assert reload.poll(100.3, force=True) is not None


def test_variants_that_are_not_drawn_any_more_go(project: Project) -> None:
    project.picture()
    project.picture(view="normal")
    effects = project.runtime.residency.effects
    assert len(effects.variants()) == 2
    for i in range(2):  # the first takes both along; then only one is drawn
        project.edit(FRAG, LAST, LAST + f" * {1 + i}.0" if i == 0 else LAST)
        project.poll()
        project.picture()
    assert len(effects.variants()) == 1


def test_a_new_effect_of_the_project_needs_no_python(gl_device: Device, tmp_path: Path) -> None:
    project = Project(gl_device, tmp_path)
    try:
        shutil.rmtree(tmp_path / "shaders")
        project.runtime.open(tmp_path / "a.scene.json")
        before = project.picture()
        effect = 'name = "flat"\nextends = "surface"\n[technique.forward]\nfragment = "effects/paper.frag"\n'
        project.write("effects/flat.effect.toml", effect)
        project.edit(MATERIAL, 'effect = "surface"', 'effect = "flat"')
        project.poll()
        assert project.problems[0].where.file.endswith("flat.effect.toml")
        assert project.problems[0].where.line == 4
        np.testing.assert_array_equal(project.picture(), before)
        code = "layout(location = 2) flat in uint v_material;\nlayout(location = 0) out vec4 o_color;\n"
        code += "void main()\n{\n    o_color = vec4(materials[v_material].base_color.rgb, 1.0);\n}\n"
        project.write("effects/paper.frag", code)
        result = project.poll()
        assert result is not None
        assert project.problems == ()
        after = project.picture()
        assert (after != before).any()
        assert len(np.unique(after[20:28, 20:28].reshape(-1, 4), axis=0)) == 1, "unlit: one colour"
        project.edit(MATERIAL, 'effect = "flat"', 'effect = "surface"')
        project.poll()
        np.testing.assert_array_equal(project.picture(), before)
    finally:
        project.runtime.close()


def test_a_hundred_files_at_once(project: Project) -> None:
    before = project.picture()
    files = [path for path in (project.folder / "shaders").rglob("*") if path.suffix in SOURCES]
    for path in files:
        project.write(str(path.relative_to(project.folder)), path.read_text(encoding="utf-8"))
    for i in range(100):
        project.write(f"shaders/lib/other{i}.glsl", "// nothing\n")
    result = project.poll()
    assert result is not None
    assert result.problems == ()
    np.testing.assert_array_equal(project.picture(), before)


def test_a_file_saved_by_rename_is_noticed(project: Project) -> None:
    before = project.picture()
    path = project.folder / FRAG
    other = path.with_suffix(".tmp")
    other.write_text(path.read_text(encoding="utf-8").replace(LAST, "sanitise(color.bgr), 1.0)"), encoding="utf-8")
    other.replace(path)
    assert project.poll() is not None
    assert (project.picture() != before).any()


def test_a_file_that_goes_and_comes_back(project: Project) -> None:
    """As editors do that remove the old file before they write the new one, and mounts that drop out."""
    before = project.picture()
    for file in (FRAG, INCLUDE, EFFECT, MATERIAL, TONE):
        path = project.folder / file
        data = path.read_bytes()
        path.unlink()
        project.poll()
        np.testing.assert_array_equal(project.picture(), before, err_msg=file)
        path.write_bytes(data)
        project.poll()
        assert project.problems == (), file
        np.testing.assert_array_equal(project.picture(), before, err_msg=file)


def test_another_branch_is_checked_out_and_back(project: Project) -> None:
    """Every file replaced by rename at once, with the time that git gives them: now."""
    before = project.picture()
    files = [path for path in (project.folder / "shaders").rglob("*") if path.suffix in SOURCES]
    files += [project.folder / MATERIAL]
    assert len(files) > 40
    main = {path: path.read_bytes() for path in files}
    for path in files:
        note = b"# other branch\n" if path.suffix == ".toml" else b"// other branch\n"
        _renamed_over(path, main[path].replace(LAST.encode(), b"sanitise(color.bgr), 1.0)") + note)
    project.poll()
    assert project.problems == ()
    assert (project.picture() != before).any()
    for path in files:
        _renamed_over(path, main[path])
    project.poll()
    assert project.problems == ()
    np.testing.assert_array_equal(project.picture(), before)


def _renamed_over(path: Path, data: bytes) -> None:
    other = path.with_name(f".{path.name}.tmp")
    other.write_bytes(data)
    other.replace(path)
