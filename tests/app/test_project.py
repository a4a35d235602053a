"""Projects: made whole or not at all, read with a place for every mistake."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine import __version__
from engine.app import project as project_module
from engine.app.project import is_project, load_project, new_project
from engine.core.errors import FormatError, InputError, OutputError, UsageError


@pytest.fixture
def template(tmp_path: Path) -> Path:
    folder = tmp_path / "template"
    (folder / "assets").mkdir(parents=True)
    (folder / ".cache").mkdir()
    (folder / ".cache" / "junk").write_bytes(b"x")
    (folder / "assets" / "thing.glb").write_bytes(b"glTF")
    (folder / ".gitignore").write_text(".cache/\n")
    (folder / "project.toml").write_text(
        '# keep me\n[project]\nname = "Template"\nstart = "assets/thing.glb"  # first\nengine = "0.0.1"\n'
    )
    return folder


def write(folder: Path, text: str) -> Path:
    folder.mkdir(exist_ok=True)
    file = folder / "project.toml"
    file.write_text(text)
    return file


def test_new_project_is_named_after_its_folder_and_keeps_comments(template: Path, tmp_path: Path) -> None:
    made = new_project(tmp_path / "deep" / "My Orrery", template=template)
    assert made.name == "My Orrery"
    assert made.engine == __version__
    assert made.start == tmp_path / "deep" / "My Orrery" / "assets" / "thing.glb"
    assert made.start.read_bytes() == b"glTF"
    text = (made.root / "project.toml").read_text()
    assert "# keep me" in text
    assert "# first" in text
    assert not made.cache_dir.exists()
    assert (made.root / ".gitignore").exists()
    assert sorted(p.name for p in made.root.parent.iterdir()) == ["My Orrery"], "nothing temporary is left"


def test_new_project_fills_an_empty_folder(template: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    assert new_project(tmp_path / "empty", template=template).name == "empty"


def test_new_project_refuses_what_is_there(template: Path, tmp_path: Path) -> None:
    full = tmp_path / "full"
    full.mkdir()
    (full / "mine.txt").write_text("mine")
    with pytest.raises(UsageError, match="not empty"):
        new_project(full, template=template)
    assert [p.name for p in full.iterdir()] == ["mine.txt"]
    with pytest.raises(UsageError, match="a file of this name"):
        new_project(full / "mine.txt", template=template)


def test_new_project_leaves_nothing_when_copying_fails(
    template: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*args: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(project_module, "_rename", fail)
    with pytest.raises(OutputError, match="No space left"):
        new_project(tmp_path / "target", template=template)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["template"]


def test_new_project_below_a_file_is_an_output_error(template: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError):
        new_project(tmp_path / "file" / "sub", template=template)


def test_load_by_folder_and_by_file(template: Path) -> None:
    assert load_project(template).start == load_project(template / "project.toml").start
    assert is_project(template)
    assert is_project(template / "project.toml")
    assert not is_project(template / "assets")
    assert not is_project(template / "assets" / "thing.glb")


def test_load_without_a_project(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no project"):
        load_project(tmp_path)


@pytest.mark.parametrize(
    ("text", "words", "place"),
    [
        ("[project\n", "Expected", "project.toml:1:"),
        ('[project]\nname = "a"\nstrat = "x"\n', "did you mean 'start'", "project.toml:3:1"),
        ('[projekt]\nname = "a"\n', "no \\[project\\] table", "project.toml"),
        ('extra = 1\n[project]\nname = "a"\nstart = "x"\n', "unknown key 'extra'", "project.toml:1:1"),
        ('[project]\nname = "a"\n', "lacks 'start'", "project.toml:1:2"),
        ('[project]\nname = 3\nstart = "x"\n', "name must be a text", "project.toml:2:1"),
        ('[project]\nname = ""\nstart = "x"\n', "name must be a text", "project.toml:2:1"),
        ('[project]\nname = "a"\nstart = "../x"\n', "leaves the project", "project.toml:3:1"),
        ('[project]\nname = "a"\nstart = "/x"\n', "leaves the project", "project.toml:3:1"),
        ('[project]\nname = "a"\nstart = "C:/x"\n', "leaves the project", "project.toml:3:1"),
        ('[project]\nname = "a"\nstart = "a\\\\..\\\\..\\\\x"\n', "leaves the project", "project.toml:3:1"),
    ],
)
def test_every_mistake_has_a_place(tmp_path: Path, text: str, words: str, place: str) -> None:
    write(tmp_path, text)
    with pytest.raises(FormatError, match=words) as caught:
        load_project(tmp_path)
    assert place in str(caught.value)


def test_missing_start_names_the_line(tmp_path: Path) -> None:
    write(tmp_path, '[project]\nname = "a"\nstart = "gone.glb"\n')
    with pytest.raises(InputError, match="is not there") as caught:
        load_project(tmp_path)
    assert "project.toml:3:1" in str(caught.value)


def test_not_text(tmp_path: Path) -> None:
    (tmp_path / "project.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FormatError, match="UTF-8"):
        load_project(tmp_path)


def test_a_newer_project_opens_with_a_warning(tmp_path: Path) -> None:
    (tmp_path / "a.glb").write_bytes(b"")
    write(tmp_path, '[project]\nname = "a"\nstart = "a.glb"\nengine = "99.0"\n')
    assert [f.code for f in load_project(tmp_path).findings] == ["project.newer-engine"]


def test_the_shipped_template_is_a_project(tmp_path: Path) -> None:
    made = new_project(tmp_path / "sample")
    assert made.start.name == "orrery.glb"
    assert len(made.findings) == 0
