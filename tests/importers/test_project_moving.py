"""`mv`: every reference follows, undo restores every byte, and what cannot be meant is refused."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import pytest

from engine.assets.material import MaterialAsset, TextureRef
from engine.assets.material_toml import read_material, write_material
from engine.assets.scene import EnvironmentAsset, MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import read_scene, write_scene
from engine.core.errors import InputError, OutputError, UsageError
from importers.cli.main import main
from importers.project import moving
from importers.project.references import all_references

EFFECT = """# a toon effect
name = "toon"
[technique.forward]
vertex = "effects/toon.vert"
fragment = "toon.frag"
"""


@pytest.fixture
def project(tmp_path: Path) -> Path:
    root = tmp_path / "game"
    for folder in ("assets/textures", "materials", "scenes", "shaders/effects", "shaders/lib"):
        (root / folder).mkdir(parents=True)
    (root / "project.toml").write_text('# mine\n[project]\nname = "Game"\nstart = "assets/fox.gltf"  # first\n')
    (root / "assets/fox.gltf").write_text(json.dumps({"buffers": [{"uri": "fox%20data.bin"}], "asset": {}}))
    (root / "assets/fox data.bin").write_bytes(b"1")
    (root / "assets/fox.gltf.import").write_text('[textures."textures/fur.dds"]\nrole = "color"\n')
    (root / "assets/textures/fur.dds").write_bytes(b"2")
    (root / "assets/sky.hdr").write_bytes(b"3")
    fur = MaterialAsset("fur", effect="toon", textures={"base_color_map": TextureRef("../assets/textures/fur.dds")})
    write_material(root / "materials/fur.material.toml", fur)
    (root / "materials/wet.material.toml").write_text(
        'schema = "lucarna.material/1"\n# wet fur\nparent = "fur.material.toml"\n[params]\nroughness = 0.1 # shiny\n'
    )
    (root / "scenes/fox.lmesh").write_bytes(b"4")
    mesh = MeshRef("fox.lmesh", 0, "fox", ["../materials/fur.material.toml", "../materials/wet.material.toml"])
    nodes = [NodeAsset("fox", mesh=mesh), NodeAsset("../materials/fur.material.toml")]
    write_scene(
        root / "scenes/fox.scene.json",
        SceneAsset("fox", nodes, environment=EnvironmentAsset("image", "../assets/sky.hdr")),
    )
    (root / "shaders/effects/toon.effect.toml").write_text(EFFECT)
    (root / "shaders/effects/toon.vert").write_text("void main() {}\n")
    (root / "shaders/effects/toon.frag").write_text('  #include "lib/ramp.glsl"\nvoid main() {}\n')
    (root / "shaders/lib/ramp.glsl").write_text("float ramp;\n")
    return root


def everything(root: Path) -> dict[str, bytes]:
    return {p.relative_to(root).as_posix(): p.read_bytes() for p in root.rglob("*") if p.is_file()}


def moved(root: Path, old: str, new: str) -> moving.Move:
    move = moving.plan(root / old, root / new)
    move.apply()
    return move


def test_a_renamed_material_is_followed_by_scenes_and_children_and_nothing_else_changes(project: Path) -> None:
    before = everything(project)
    move = moved(project, "materials/fur.material.toml", "materials/coat.material.toml")
    scene = read_scene(project / "scenes/fox.scene.json")
    assert scene.nodes[0].mesh is not None
    assert scene.nodes[0].mesh.materials == ["../materials/coat.material.toml", "../materials/wet.material.toml"]
    assert scene.nodes[1].name == "../materials/fur.material.toml", "a name is no reference"
    child = (project / "materials/wet.material.toml").read_text()
    assert 'parent = "coat.material.toml"' in child
    assert "roughness = 0.1 # shiny" in child
    assert read_material(project / "materials/wet.material.toml").effect == "toon"
    move.undo()
    assert everything(project) == before


def test_a_folder_takes_its_own_references_along(project: Path) -> None:
    before = everything(project)
    move = moved(project, "materials", "assets/looks")
    assert not (project / "materials").exists()
    fur = read_material(project / "assets/looks/fur.material.toml")
    assert fur.textures["base_color_map"].path == "../textures/fur.dds"
    mesh = read_scene(project / "scenes/fox.scene.json").nodes[0].mesh
    assert mesh is not None
    assert mesh.materials[0] == "../assets/looks/fur.material.toml"
    move.undo()
    assert everything(project) == before


def test_a_source_takes_its_sidecar_and_the_project_opens_it_still(project: Path) -> None:
    moved(project, "assets/fox.gltf", "assets/wolf.gltf")
    text = (project / "project.toml").read_text()
    assert tomllib.loads(text)["project"]["start"] == "assets/wolf.gltf"
    assert "# first" in text
    assert (project / "assets/wolf.gltf.import").is_file()
    moved(project, "assets/textures/fur.dds", "assets/textures/hair.dds")
    assert tomllib.loads((project / "assets/wolf.gltf.import").read_text())["textures"] == {
        "textures/hair.dds": {"role": "color"}
    }


def test_a_source_never_loses_what_it_names(project: Path) -> None:
    before = everything(project)
    with pytest.raises(InputError, match=r"fox\.gltf names fox data.bin"):
        moving.plan(project / "assets/fox data.bin", project / "assets/data.bin")
    with pytest.raises(InputError, match=r"fox\.gltf names fox data.bin"):
        moving.plan(project / "assets/fox.gltf", project / "scenes")
    assert everything(project) == before
    moved(project, "assets", "models")
    assert (project / "models/fox data.bin").is_file()


def test_effects_go_by_their_names_and_shaders_by_their_places(project: Path) -> None:
    before = everything(project)
    move = moved(project, "shaders/effects/toon.effect.toml", "shaders/effects/ink.effect.toml")
    assert read_material(project / "materials/fur.material.toml").effect == "ink"
    effect = (project / "shaders/effects/ink.effect.toml").read_text()
    assert tomllib.loads(effect)["name"] == "ink"
    assert effect.startswith("# a toon effect")
    moved(project, "shaders/lib/ramp.glsl", "shaders/lib/steps.glsl")
    assert '  #include "lib/steps.glsl"\n' in (project / "shaders/effects/toon.frag").read_text()
    moved(project, "shaders/lib/steps.glsl", "shaders/lib/ramp.glsl")
    move.undo()
    assert everything(project) == before


@pytest.mark.parametrize(
    ("old", "new", "error"),
    [
        ("materials/fur.material.toml", "materials/wet.material.toml", "already"),
        ("materials/fur.material.toml", "materials/fur.toml", "call it fur.material.toml"),
        ("materials/fur.material.toml", "materials/a:b.material.toml", "no good name"),
        ("materials/fur.material.toml", "materials/con.material.toml", "Windows keeps it"),
        ("materials/fur.material.toml", "../outside.material.toml", "outside the project"),
        ("materials", "materials/inner", "into itself"),
        ("project.toml", "other.toml", "cannot be moved"),
        ("materials/fur.material.toml", "materials/fur.material.toml", "the old one"),
        ("materials/none.material.toml", "materials/some.material.toml", "no such file"),
    ],
)
def test_what_cannot_be_meant_is_refused_and_changes_nothing(project: Path, old: str, new: str, error: str) -> None:
    before = everything(project)
    with pytest.raises((UsageError, InputError), match=error):
        moved(project, old, new)
    assert everything(project) == before


def test_a_failure_on_the_way_puts_everything_back(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = everything(project)
    move = moving.plan(project / "materials/fur.material.toml", project / "materials/coat.material.toml")
    real = moving.write_bytes
    left = [1]

    def full(path: Path, data: bytes) -> None:
        if left[0] == 0 and b"coat" in data:
            raise OutputError("the disk is full", where=path)
        left[0] -= 1
        real(path, data)

    monkeypatch.setattr(moving, "write_bytes", full)
    with pytest.raises(OutputError, match="full"):
        move.apply()
    assert everything(project) == before


def test_used_by_and_uses(project: Path) -> None:
    found = all_references(project)
    fur = project / "materials/fur.material.toml"
    assert {r.file.name for r in moving.used_by(fur, found)} == {"fox.scene.json", "wet.material.toml"}
    assert {r.target.name for r in moving.uses(fur, found)} == {"fur.dds", "toon.effect.toml"}


def test_the_command(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = everything(project)
    arguments = ["mv", str(project / "assets/sky.hdr"), str(project / "assets/dawn.hdr")]
    assert main([*arguments, "--dry-run", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["rewritten"] == ["scenes/fox.scene.json"]
    assert everything(project) == before
    assert main(arguments) == 0
    assert "rewrote scenes/fox.scene.json" in capsys.readouterr().out
    assert read_scene(project / "scenes/fox.scene.json").environment.path == "../assets/dawn.hdr"
    assert main(arguments) == 1, "it is not there any more"
