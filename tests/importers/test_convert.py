"""Conversion as a whole: files, names, determinism, caches, and the findings of real files."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from engine.assets.lanim import read_lanim
from engine.assets.lmesh import read_lmesh
from engine.assets.material_toml import read_material
from engine.assets.scene_json import read_scene
from engine.core.errors import FormatError, UsageError
from importers.cache import scene_for
from importers.checks.files import check_file
from importers.convert import convert
from importers.naming import UniqueNames, safe_name
from importers.settings import ImportSettings
from tests.support.gltf_builder import GltfBuilder, png, textured_triangle, triangle

SETTINGS = ImportSettings()


def digests(folder: Path) -> dict[str, str]:
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in sorted(folder.iterdir())}


def animated() -> GltfBuilder:
    b = textured_triangle()
    sampler = {"input": b.accessor([0, 1]), "output": b.accessor([[0, 0, 0], [1, 0, 0]])}
    channel = {"sampler": 0, "target": {"node": 0, "path": "translation"}}
    b.root["animations"] = [{"name": "Go/Up", "samplers": [sampler], "channels": [channel]}]
    return b


def test_everything_is_written_and_refers_to_itself(tmp_path: Path) -> None:
    result = convert(animated().write_glb(tmp_path / "my model.glb"), tmp_path / "out", SETTINGS)
    names = [p.name for p in result.outputs]
    assert names == [
        "my_model.Go_Up.lanim",
        "my_model.lmesh",
        "my_model.paint.base_color.dds",
        "my_model.paint.material.toml",
        "my_model.paint.normal.dds",
        "my_model.scene.json",
    ]
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == names
    assert result.scene == tmp_path / "out" / "my_model.scene.json"
    scene = read_scene(result.scene)
    assert scene.provenance["source"] == "my model.glb"
    mesh = scene.nodes[0].mesh
    assert mesh is not None
    assert (mesh.file, mesh.materials) == ("my_model.lmesh", ["my_model.paint.material.toml"])
    assert read_lmesh(tmp_path / "out" / mesh.file)[mesh.index].vertex_count == 3
    assert read_lanim(tmp_path / "out" / scene.clips[0]).channels[0].target == "node_0"
    textures = read_material(tmp_path / "out" / mesh.materials[0]).textures
    assert {slot: t.path for slot, t in textures.items()} == {
        "base_color_map": "my_model.paint.base_color.dds",
        "normal_map": "my_model.paint.normal.dds",
    }
    for path in result.outputs:
        assert not list(check_file(path, SETTINGS))


def test_same_input_same_bytes_with_and_without_the_cache(tmp_path: Path) -> None:
    source = animated().write_glb(tmp_path / "a.glb")
    convert(source, tmp_path / "one", SETTINGS)
    convert(source, tmp_path / "two", SETTINGS)
    convert(source, tmp_path / "three", ImportSettings(use_texture_cache=False, jobs=1))
    assert digests(tmp_path / "one") == digests(tmp_path / "two") == digests(tmp_path / "three")


def test_one_image_in_two_roles_gives_two_textures(tmp_path: Path) -> None:
    b = textured_triangle()
    b.root["materials"][0]["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {"index": 1}
    b.root["materials"][0]["occlusionTexture"] = {"index": 1}
    b.root["images"][1]["name"] = "orm"
    b.material(name="other", pbrMetallicRoughness={"metallicRoughnessTexture": {"index": 1}})
    result = convert(b.write_glb(tmp_path / "a.glb"), tmp_path / "out", SETTINGS)
    textures = sorted(p.name for p in result.outputs if p.suffix == ".dds")
    assert textures == ["a.orm.metal_rough.dds", "a.orm.normal.dds", "a.orm.occlusion.dds", "a.paint.base_color.dds"]
    other = read_material(tmp_path / "out" / "a.other.material.toml")
    assert other.textures["metal_rough_map"].path == "a.orm.metal_rough.dds"


def test_equal_names_become_different_files(tmp_path: Path) -> None:
    b = triangle()
    for name in ("Red", "red", "RED", "..", "a/b", "a:b"):
        b.material(name=name)
    result = convert(b.write_glb(tmp_path / "a.glb"), tmp_path / "out", SETTINGS)
    names = [p.name for p in result.outputs if p.suffix == ".toml"]
    assert len({n.casefold() for n in names}) == len(names) == 6
    assert "a.unnamed.material.toml" in names


def test_safe_names() -> None:
    assert safe_name("../../etc/passwd") == "etc_passwd"
    assert safe_name("a b\tc\x00d") == "a_b_c_d"
    assert safe_name("   ") == "unnamed"
    assert safe_name("Übergröße") == "Übergröße"
    assert len(safe_name("x" * 500)) == 60
    names = UniqueNames()
    assert [names.take("a"), names.take("A"), names.take("a")] == ["a", "A_2", "a_3"]


def test_unused_outputs_of_others_stay(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("kept")
    convert(triangle().write_glb(tmp_path / "a.glb"), tmp_path / "out", SETTINGS)
    assert (tmp_path / "out" / "mine.txt").read_text() == "kept"


def test_cache_is_by_content_not_by_place(tmp_path: Path) -> None:
    first, findings = scene_for(animated().write_glb(tmp_path / "a.glb"))
    assert first.is_file()
    assert not findings.has_errors
    (tmp_path / "moved").mkdir()
    again, _ = scene_for((tmp_path / "a.glb").rename(tmp_path / "moved" / "a.glb"))
    assert again == first
    changed, _ = scene_for(triangle().write_glb(tmp_path / "moved" / "a.glb"))
    assert changed != first
    other, _ = scene_for(tmp_path / "moved" / "a.glb", settings=ImportSettings(quality="draft"))
    assert other != changed


def test_cache_sees_a_changed_dependency_and_keeps_findings(tmp_path: Path) -> None:
    b = textured_triangle()
    b.root["images"][0] = {"uri": "skin.png"}
    path = b.write_gltf(tmp_path / "a.gltf")
    missing, findings = scene_for(path)
    recalled, findings_again = scene_for(path)
    assert recalled == missing
    assert findings.has_errors
    assert findings.items == findings_again.items
    (tmp_path / "skin.png").write_bytes(png(2, 2))
    found, findings = scene_for(path)
    assert found != missing
    assert not findings.has_errors


def test_damaged_cache_entry_is_made_anew(tmp_path: Path) -> None:
    path = triangle().write_glb(tmp_path / "a.glb")
    scene, _ = scene_for(path)
    (scene.parent / "import.json").write_text("{broken")
    again, _ = scene_for(path)
    assert again == scene
    assert read_scene(again).nodes


def test_scene_file_passes_through(tmp_path: Path) -> None:
    path = tmp_path / "x.scene.json"
    assert scene_for(path)[0] == path


def test_settings_are_checked() -> None:
    with pytest.raises(UsageError, match="unknown quality"):
        ImportSettings(quality="best")


def test_findings_of_real_files(shared_assets: Path, tmp_path: Path) -> None:
    man = shared_assets / "gltf" / "CesiumMan" / "glTF-Binary" / "CesiumMan.glb"
    result = convert(man, tmp_path / "man", SETTINGS)
    assert [f.code for f in result.findings] == ["gltf.weights", "clip.keys"]
    assert "210 of 3,273" in next(iter(result.findings)).message
    assert len(read_lanim(tmp_path / "man" / "CesiumMan.clip_0.lanim").channels) == 57
    broken = shared_assets / "malformed" / "no_newline.mesh"
    with pytest.raises(FormatError):
        convert(broken, tmp_path / "broken", SETTINGS)
    assert not (tmp_path / "broken").exists()


def test_every_container_of_a_model_gives_the_same_mesh(shared_assets: Path, tmp_path: Path) -> None:
    seen = set()
    for name in ("glTF-Binary/Duck.glb", "glTF/Duck.gltf", "glTF-Embedded/Duck.gltf"):
        folder = tmp_path / name.split("/")[0]
        convert(shared_assets / "gltf" / "Duck" / name, folder, SETTINGS)
        mesh = read_lmesh(folder / "Duck.lmesh")[0]
        seen.add(hashlib.sha256(b"".join(mesh.streams[s].tobytes() for s in mesh.layout)).hexdigest())
    assert len(seen) == 1
