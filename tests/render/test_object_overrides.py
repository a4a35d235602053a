"""Parameters of materials that are other on one object: picture, batches, following the material, file, mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from engine.app.runtime import Runtime
from engine.assets.lmesh import write_lmesh
from engine.assets.primitives import cube
from engine.assets.scene import EnvironmentAsset, MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import format_scene, parse_scene, read_scene, write_scene
from engine.core.errors import FormatError, InputError, UsageError
from engine.gpu.types import Device
from tests.support.effect_project import EffectProject, picture

PAINT = 'name = "paint"\nfeatures = ["unlit"]\n[params]\nbase_color = [0.5, 0.5, 0.5, 1.0]\n'


def scene_of(folder: Path, overrides: dict[str, list[dict[str, object]]]) -> EffectProject:
    """Boxes left, middle and right of one material."""
    project = EffectProject(folder, {"paint.material.toml": PAINT, "thing.material.toml": PAINT})
    write_lmesh(folder / "b.lmesh", [cube(0.4)], {})
    nodes = [
        NodeAsset(
            name, translation=(x, 0.0, 0.0),
            mesh=MeshRef("b.lmesh", 0, "", ["paint.material.toml"], overrides.get(name, [])),
        )
        for name, x in (("left", -0.6), ("middle", 0.0), ("right", 0.6))
    ]  # fmt: skip
    look = EnvironmentAsset("none", background="color", background_color=(0.0, 0.0, 0.0))
    write_scene(project.scene, SceneAsset("a", nodes, environment=look))
    return project


@pytest.fixture
def project(tmp_path: Path) -> EffectProject:
    return scene_of(tmp_path, {"right": [{"base_color": [1.0, 0.0, 0.0, 1.0]}]})


@pytest.fixture
def runtime(gl_device: Device, project: EffectProject) -> Iterator[Runtime]:
    made = project.open(gl_device)
    yield made
    made.close()


def colors(runtime: Runtime) -> list[tuple[int, ...]]:
    """Of the boxes from left to right, in the view that shows base colours."""
    seen = picture(runtime, (96, 48), view="base_color")
    found: dict[tuple[int, ...], list[int]] = {}
    for x in range(96):
        for pixel in seen[:, x]:
            if pixel[:3].max() > 40:
                found.setdefault(tuple(int(v) for v in pixel[:3]), []).append(x)
    return sorted((c for c, xs in found.items() if len(xs) > 20), key=lambda c: np.mean(found[c]))


def row(runtime: Runtime, name: str) -> int:
    return int(runtime.node_rows[[n.name for n in runtime.asset.nodes].index(name)])


def test_one_object_is_other_in_the_same_batch(runtime: Runtime) -> None:
    gray, red = colors(runtime)
    assert gray[0] == gray[1] == gray[2]
    assert red[0] > 200
    assert red[1] < 30
    assert [b.count for b in runtime.renderer.draws.opaque] == [1], "one command: rows differ, nothing else"
    runtime.objects.set(row(runtime, "left"), 0, {"base_color": (0.0, 0.0, 1.0, 1.0)})
    assert [c[2] > 200 for c in colors(runtime)] == [True, False, False]
    assert [b.count for b in runtime.renderer.draws.opaque] == [1]
    compiled = runtime.residency.effects.compiled
    runtime.objects.set(row(runtime, "left"), 0, {"base_color": (0.0, 1.0, 0.0, 1.0)})
    assert colors(runtime)[0][1] > 200
    runtime.objects.set(row(runtime, "left"), 0, {"base_color": None})
    assert colors(runtime) == [gray, red]
    assert runtime.residency.effects.compiled == compiled


def test_what_it_does_not_say_follows_the_material(runtime: Runtime, project: EffectProject) -> None:
    """Edited in the window, in the file, and with another effect."""
    own, residency = row(runtime, "right"), runtime.residency
    base = runtime.objects.slots(own)[0]
    material = int(runtime.scene.instances.material[np.flatnonzero(runtime.scene.instances.node == own)[0]])
    assert material != base
    residency.set_material_param(base, "roughness", 0.25)
    residency.set_material_param(base, "base_color", (0.0, 1.0, 0.0, 1.0))
    rows = residency.materials.rows_of("surface")
    assert rows[residency.material(material).row]["roughness"] == np.float32(0.25)
    assert [c[:2] for c in ((c[0] > 200, c[1] > 200) for c in colors(runtime))] == [(False, True), (True, False)]
    project.write("paint.material.toml", PAINT + "metallic = 0.125\n")
    assert runtime.hot_reload.poll(force=True) is not None
    assert residency.materials.get_param(material, "metallic") == 0.125
    assert residency.materials.get_param(material, "base_color")[:3] == (1.0, 0.0, 0.0)
    project.write("paint.material.toml", 'name = "paint"\neffect = "uv_checker"\n')
    assert runtime.hot_reload.poll(force=True) is not None
    assert residency.material(material).effect.name == "uv_checker"
    assert not runtime.hot_reload.problems
    picture(runtime)


def test_a_copy_of_the_object_stays_as_it_is_when_that_is_changed(runtime: Runtime) -> None:
    table = runtime.scene.instances
    left, right = row(runtime, "left"), row(runtime, "right")
    mine = int(table.material[np.flatnonzero(table.node == right)[0]])
    table.set_material(np.flatnonzero(table.node == left), mine)  # as a copy has it
    runtime.scene.sources[left] = runtime.scene.sources[right]
    runtime.objects.set(right, 0, {"base_color": (0.0, 0.0, 1.0, 1.0)})
    assert [c[0] > 200 for c in colors(runtime)] == [True, False, False]


def test_the_file_says_it_and_what_no_effect_knows_is_told(gl_device: Device, tmp_path: Path) -> None:
    project = scene_of(
        tmp_path, {"left": [{"roughnes": 0.5, "metallic": 7.0, "roughness": 0.5}], "right": [{}, {"a": 1}]}
    )
    again = read_scene(project.scene)
    assert parse_scene(format_scene(again), "x") == again
    runtime = project.open(gl_device)
    try:
        told = [str(f) for f in runtime.findings if f.code == "object.override"]
        assert len(told) == 3
        assert any("roughnes" in t and "did you mean 'roughness'?" in t and "left" in t for t in told)
        assert any("metallic" in t for t in told)
        assert any("no material slot 1" in t for t in told)
        assert runtime.objects.values(row(runtime, "left"), 0)["roughness"] == 0.5
        with pytest.raises(UsageError, match="roughnes"):
            runtime.objects.set(row(runtime, "left"), 0, {"roughnes": 0.5})
        with pytest.raises(InputError, match="slot 3"):
            runtime.objects.set(row(runtime, "left"), 3, {"roughness": 0.5})
    finally:
        runtime.close()


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ('"overrides": [{"roughness": null}]', "overrides[0].roughness"),
        ('"overrides": [{"base_color": [1, 2, 3, 4, 5]}]', "5 numbers; a parameter has 2 to 4"),
        ('"overrides": [3]', "overrides[0]"),
        ('"overrides": {"roughness": 1}', "overrides"),
        ('"override": []', "did you mean 'overrides'"),
    ],
)
def test_mistakes_in_the_file(value: str, message: str) -> None:
    text = '{"schema": "lucarna.scene/1", "name": "a", "nodes": [{"name": "n", "mesh": {"file": "a", "index": 0, %s}}]}'
    with pytest.raises(FormatError) as caught:
        parse_scene(text % value, "a.scene.json")
    assert message in str(caught.value)


def test_from_the_command_line(gl_device: Device, project: EffectProject, capsys: pytest.CaptureFixture[str]) -> None:
    from engine.report.image import load_png
    from importers.cli.main import main

    out = project.folder / "a.png"
    arguments = ["render", str(project.scene), "--out", str(out), "--size", "96x48", "--view", "base_color"]
    assert main([*arguments, "--set", "objects.left.base_color=0,0,1,1"]) == 0
    seen = load_png(out)[..., :3].astype(int)
    assert ((seen[..., 2] > 200) & (seen[..., 0] < 30)).any()
    for wrong, told in (
        ("objects.lefd.roughness=1", "did you mean 'left'"),
        ("objects.left.roughnes=1", "'roughness'"),
    ):
        assert main([*arguments, "--set", wrong]) != 0
        assert told in capsys.readouterr().err


def test_two_thousand_objects_stay_one_command(null_device: Device, tmp_path: Path) -> None:
    project = scene_of(tmp_path, {})
    scene = read_scene(project.scene)
    scene.nodes = [
        NodeAsset(f"n{i}", mesh=MeshRef("b.lmesh", 0, "", ["paint.material.toml"], [{"roughness": i / 2000}]))
        for i in range(2000)
    ]
    write_scene(project.scene, scene)
    runtime = project.open(null_device)
    try:
        picture(runtime)
        assert [b.count for b in runtime.renderer.draws.opaque] == [1]
        assert runtime.renderer.draws.instances_drawn == 2000
    finally:
        runtime.close()
