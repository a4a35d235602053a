"""Settings from defaults, project, preset, sidecar and flags: who wins, and where a mistake stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.core.errors import FormatError, UsageError
from importers.presets import SettingsResolver, save_sidecar, sidecar_path
from importers.settings import ImportSettings, declared


@pytest.fixture
def fox(tmp_path: Path) -> Path:
    (tmp_path / "project.toml").write_text(
        '[project]\nname = "P"\nstart = "a/fox.glb"\n[import]\nmax_texture_size = 2048\npreset = "stage"\n'
        '[presets.stage]\nquality = "high"\n'
    )
    (tmp_path / "presets").mkdir()
    (tmp_path / "presets" / "mobile.toml").write_text("max_texture_size = 512\n")
    (tmp_path / "a").mkdir()
    path = tmp_path / "a" / "fox.glb"
    path.write_bytes(b"x")
    return path


def test_later_origins_win(fox: Path) -> None:
    plain = SettingsResolver().resolve(fox)
    assert (plain.settings.max_texture_size, plain.settings.quality) == (2048, "high")
    assert plain.origins == {
        "max_texture_size": "project.toml:5", "quality": "preset stage (project.toml:8)",
    }  # fmt: skip
    sidecar_path(fox).write_text('preset = "mobile"\ncompress = false\n')
    beside = SettingsResolver().resolve(fox)
    assert (beside.settings.max_texture_size, beside.settings.quality, beside.settings.compress) == (
        512, "normal", False,
    )  # fmt: skip
    assert beside.origins["compress"] == "fox.glb.import:2"
    said = SettingsResolver(preset="draft", flags={"compress": True}).resolve(fox)
    assert (said.settings.max_texture_size, said.settings.quality, said.settings.compress) == (2048, "draft", True)
    assert said.origins["compress"] == "--compress"


@pytest.mark.parametrize(
    ("text", "place", "hint"),
    [
        ("max_texture_sise = 4\n", "fox.glb.import:1:1", "did you mean 'max_texture_size'?"),
        ("\n  quality = 'hihg'\n", "fox.glb.import:2:13", "did you mean 'high'?"),
        ("max_texture_size = -1\n", "fox.glb.import:1:20", "0 or more texels"),
        ("compress = 1\n", "fox.glb.import:1:12", "true or false"),
        ("preset = 'moblie'\n", "fox.glb.import:1:10", "did you mean 'mobile'?"),
        ("a = = 2\n", "fox.glb.import:1:5", ""),
    ],
)
def test_mistakes_have_a_place(fox: Path, text: str, place: str, hint: str) -> None:
    sidecar_path(fox).write_text(text)
    with pytest.raises(FormatError) as caught:
        SettingsResolver().resolve(fox)
    assert place in str(caught.value)
    assert hint in str(caught.value)
    assert "^" in str(caught.value)


def test_a_sidecar_holds_only_differences(fox: Path) -> None:
    path = save_sidecar(fox, {"max_texture_size": 1024, "quality": "high"})
    assert path.read_text() == "max_texture_size = 1024\n"  # the project says high already
    path.write_text("# the hero\nmax_texture_size = 1024\ncompress = false\n")
    save_sidecar(fox, {"max_texture_size": 4096, "compress": None}, "draft")
    assert path.read_text() == '# the hero\npreset = "draft"\nmax_texture_size = 4096\n' or (
        "# the hero" in path.read_text() and "compress" not in path.read_text()
    )
    assert SettingsResolver().resolve(fox).settings.quality == "draft"
    path.unlink()
    assert not save_sidecar(fox, {"quality": "high"}).exists()
    with pytest.raises(UsageError, match="unknown setting"):
        save_sidecar(fox, {"qualty": "high"})
    with pytest.raises(UsageError, match="give 0 or more texels"):
        save_sidecar(fox, {"max_texture_size": -4})


def test_every_declaration_is_sound() -> None:
    settings = ImportSettings()
    for name, info in declared().items():
        assert info.doc, name
        assert info.check(getattr(settings, name)) == info.default
    assert "max_worker_seconds" not in settings.key()
    assert settings.key() != settings.replace(compress=False).key()
    assert settings.key("source") == settings.replace(compress=False).key("source")
