"""What is converted into what: mirrored trees, names that would collide, odd entries of folders."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from engine.core.errors import UsageError
from importers.checks.files import checkable_files
from importers.cli.main import main
from importers.farm.plan import Plan, make_plan
from importers.presets import SettingsResolver
from tests.support.gltf_builder import png, triangle


def plan(*words: Path | str, out: Path = Path("out"), preset: str = "") -> Plan:
    return make_plan([str(word) for word in words], out, SettingsResolver(preset=preset))


def touch(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(b"x")


def targets(found: Plan) -> list[str]:
    return [(job.folder / job.name).as_posix() for job in found.jobs]


def test_the_tree_is_mirrored_and_equal_names_stay_apart(tmp_path: Path) -> None:
    touch(tmp_path, "a/fox.glb", "b/fox.glb", "b/fox.gltf", "fox.FBX", "b/notes.txt")
    assert targets(plan(tmp_path)) == ["out/a/fox", "out/b/fox", "out/b/fox_gltf", "out/fox"]


def test_letter_case_alone_is_no_difference(tmp_path: Path) -> None:
    touch(tmp_path, "Fox.glb", "fox.glb", "Sub/x.glb", "sub/X.glb")
    if len(list(tmp_path.iterdir())) < 4:
        pytest.skip("the file system ignores letter case")
    found = targets(plan(tmp_path))
    assert len({text.casefold() for text in found}) == 4


def test_no_name_is_the_beginning_of_another(tmp_path: Path) -> None:
    touch(tmp_path, "fox.glb", "fox.walk.glb", "ninja.mesh", "ninja.mesh.xml")
    assert targets(plan(tmp_path)) == ["out/fox", "out/fox_walk_glb", "out/ninja", "out/ninja_mesh_xml"]


def test_long_names_that_are_cut_alike(tmp_path: Path) -> None:
    touch(tmp_path, *(f"{'n' * 200}{i}.glb" for i in range(3)))
    found = targets(plan(tmp_path))
    assert len(set(found)) == 3
    assert all(len(Path(text).name) < 80 for text in found)


def test_unicode_names_stay(tmp_path: Path) -> None:
    touch(tmp_path, "Füchse/狐.glb")
    assert targets(plan(tmp_path)) == ["out/Füchse/狐"]


def test_the_output_folder_is_no_source(tmp_path: Path) -> None:
    touch(tmp_path, "a.glb", "out/b.glb", ".git/c.glb", "__pycache__/d.glb")
    assert [job.source.name for job in plan(tmp_path, out=tmp_path / "out").jobs] == ["a.glb"]


def test_loops_of_links_and_odd_entries(tmp_path: Path) -> None:
    touch(tmp_path, "a.glb")
    (tmp_path / "dir.glb").mkdir()
    try:
        (tmp_path / "loop").symlink_to(tmp_path)
        (tmp_path / "self.glb").symlink_to(tmp_path / "self.glb")
    except OSError:
        pytest.skip("no links here")
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.glb")
    # the link that leads nowhere is a source that cannot be read, which its worker will say
    assert [job.source.name for job in plan(tmp_path).jobs] == ["a.glb", "self.glb"]


def test_patterns_keep_what_is_below_their_fixed_part(tmp_path: Path) -> None:
    touch(tmp_path, "a/x.glb", "a/b/y.glb", "a/b/z.gltf")
    assert targets(plan(tmp_path / "a" / "**" / "*.glb")) == ["out/b/y", "out/x"]
    assert "no file matches" in plan(tmp_path / "*.obj").refused[0].error


def test_a_source_named_twice_is_one_job(tmp_path: Path) -> None:
    touch(tmp_path, "a.glb")
    assert len(plan(tmp_path, tmp_path / "a.glb", tmp_path / "*.glb").jobs) == 1


def test_what_is_not_there_stops_nothing_else(tmp_path: Path) -> None:
    touch(tmp_path, "model.glb")
    found = plan(tmp_path / "modle.glb", tmp_path / "model.glb")
    assert len(found.jobs) == 1
    assert "did you mean 'model.glb'" in found.refused[0].error
    with pytest.raises(UsageError, match="unknown preset 'darft'"):
        plan(tmp_path, preset="darft")


def test_names_that_no_one_would_choose(tmp_path: Path, capsys: pytest.CaptureFixture[str], real_workers: None) -> None:
    """As long as the system allows, with line ends, dashes, percent signs, decomposed letters, no text at all."""
    depot = tmp_path / "depot"
    depot.mkdir()
    names = [
        b"n" * 250 + b".glb",
        b"two\nlines.glb",
        b"--out.glb",
        b"100%.glb",
        b"u\xcc\x88.glb",
        b"\xff\xfe.glb",
    ]
    data, made = triangle().glb(), 0
    for name in names:
        try:
            (depot / os.fsdecode(name)).write_bytes(data)
            made += 1
        except (OSError, ValueError):
            continue
    if made < 5:
        pytest.skip("the file system takes plain names only")
    for expected in (f"{made} converted", f"nothing to do: {made} up to date"):
        assert main(["convert", str(depot), "--out", str(tmp_path / "out")]) == 0
        assert expected in capsys.readouterr().out
    assert len(list((tmp_path / "out").glob("*.scene.json"))) == made


def test_images_are_sources_where_a_folder_holds_nothing_else(tmp_path: Path) -> None:
    touch(tmp_path, "models/a.glb", "models/skin.png", "pictures/b.png", "pictures/c.psd", "pictures/notes.txt")
    assert targets(plan(tmp_path)) == ["out/models/a"]
    assert targets(plan(tmp_path / "pictures")) == ["out/b", "out/c"]
    assert [p.name for p in checkable_files(tmp_path / "pictures")] == ["b.png", "c.psd"]


def test_images_that_make_one_texture_are_one_job(tmp_path: Path) -> None:
    touch(tmp_path, *(f"sky_{face}.png" for face in ("px", "nx", "py", "ny", "pz", "nz")), "moon_px.png", "sky.png")
    touch(tmp_path, "tile_00.png", "tile_01.png")
    assert targets(plan(tmp_path)) == ["out/moon_px", "out/sky", "out/sky_png", "out/tile_00", "out/tile_01"]
    layers = make_plan([str(tmp_path / "tile*")], Path("out"), SettingsResolver(flags={"image_as": "array"}))
    assert targets(layers) == ["out/tile"]


def test_a_cube_is_called_what_its_faces_share(tmp_path: Path) -> None:
    faces = ("px", "nx", "py", "ny", "pz", "nz")
    touch(tmp_path, *(f"noon_{face}.png" for face in faces), *(f"dusk/{face}.png" for face in faces))
    assert targets(plan(tmp_path)) == ["out/dusk/dusk", "out/noon"]


def test_images_that_no_model_asks_for_are_told_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    depot, arguments = tmp_path / "depot", ["--out", str(tmp_path / "out")]
    touch(depot, "spare.png")
    (depot / "skin.png").write_bytes(png(4, 4))
    fox = triangle()
    fox.material(pbrMetallicRoughness={"baseColorTexture": {"index": fox.texture({"uri": "skin.png"})}})
    fox.root["meshes"][0]["primitives"][0]["material"] = 0
    fox.write_gltf(depot / "fox.gltf")
    for _ in range(2):  # a second run knows it as well
        main(["convert", str(depot), *arguments])
        said = capsys.readouterr().out
        assert f"1 image is used by no model here and left out: {depot / 'spare.png'};" in said
        assert "skin.png;" not in said


def test_a_wrong_sidecar_is_no_old_story(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    source, out = triangle().write_glb(tmp_path / "fox.glb"), tmp_path / "out"
    assert main(["convert", str(source), "--out", str(out)]) == 0
    source.with_name("fox.glb.import").write_text('qualty = "high"\n')
    assert main(["convert", str(source), "--out", str(out)]) == 1
    said = capsys.readouterr()
    assert "did you mean 'quality'" in said.err
    assert "as before" not in said.err + said.out
    assert "1 failed" in said.out


def test_checking_what_is_not_there(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    touch(tmp_path, "model")
    assert main(["check", str(tmp_path / "modle")]) == 1
    assert "there is no such file or folder (did you mean 'model'?)" in capsys.readouterr().err


def test_parts_of_other_sources_say_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    touch(tmp_path, "ninja.skeleton", "ninja.lmesh")
    assert main(["convert", *(str(p) for p in sorted(tmp_path.iterdir())), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "a skeleton is read with the .mesh that names it" in said
    assert "it is an engine file already" in said


def test_a_folder_that_may_not_be_searched_is_not_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    touch(tmp_path, "a.glb", "closed/b.glb")
    scandir = os.scandir

    def refusing(path: str) -> object:
        if Path(path).name == "closed":
            raise PermissionError(13, "Permission denied", path)
        return scandir(path)

    monkeypatch.setattr(os, "scandir", refusing)
    found = plan(tmp_path)
    assert targets(found) == ["out/a"]
    assert "cannot search the folder: Permission denied" in found.refused[0].error
    assert len(plan(tmp_path / "closed").refused) == 1
