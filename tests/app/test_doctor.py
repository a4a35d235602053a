"""The doctor: every check stands alone, and its exit code says whether pictures can be made here."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from editor.fonts import cjk_font
from engine.app import doctor, system_libraries
from engine.app.system_libraries import REQUIREMENTS, distribution, has_driver, install_hint, missing, packages
from engine.core.errors import DeviceError
from engine.gpu.types import Caps
from importers.cli import doctor as command
from importers.glyphs import lacking

CAPS = Caps("gl", "Imaginary 3000", "4.6", False, True, True, True, 16384, 2048, 16.0, 2**27, 1024, True,
            frozenset({"B", "A"}))  # fmt: skip


class FakeDevice:
    def __init__(self, caps: Caps = CAPS) -> None:
        self.caps = caps
        self.released = False

    def release(self) -> None:
        self.released = True


@pytest.fixture(autouse=True)
def own_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LUCARNA_CACHE", str(tmp_path / "cache"))
    monkeypatch.setenv("LUCARNA_CONFIG", str(tmp_path / "config"))


def by_name(report: doctor.Report) -> dict[str, doctor.Check]:
    return {check.name: check for check in report.checks}


def test_a_device_is_described_and_released(tmp_path: Path) -> None:
    device: Any = FakeDevice()
    report = doctor.examine(lambda: device)
    assert report.exit_code == 0
    assert device.released
    assert "Imaginary 3000" in report.to_text()
    assert "16384 px" in report.to_text()
    data = json.loads(json.dumps(report.to_json()))
    assert data["device"]["max_ssbo_bytes"] == 2**27
    assert data["device"]["extensions"] == ["A", "B"]
    assert not (tmp_path / "cache").exists(), "asking makes nothing"


def test_no_device_is_exit_code_3_with_advice() -> None:
    def refuse() -> Any:
        raise DeviceError("there is no OpenGL here", hint="install one")

    report = doctor.examine(refuse)
    assert report.exit_code == 3
    assert by_name(report)["device"].hint == "install one"
    assert {"python", "cache", "display"} <= set(by_name(report)), "the other checks are still there"
    assert report.to_json()["ok"] is False
    assert report.to_json()["device"] is None


def test_a_missing_library_of_the_backend_is_no_traceback() -> None:
    def broken() -> Any:
        raise OSError("libGL.so.1: cannot open shared object file")

    assert "libGL.so.1" in by_name(doctor.examine(broken))["device"].found


def test_weak_devices_get_warnings() -> None:
    weak = Caps("gl", "llvmpipe", "4.5", True, False, True, False, 8192, 2048, 1.0, 2**27, 1024, False)
    checks = by_name(doctor.examine(lambda: FakeDevice(weak)))  # type: ignore[arg-type, return-value]  # a test double
    assert [checks[name].status for name in ("speed", "depth", "textures")] == ["warn"] * 3


def test_missing_packages_name_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_requirements", lambda: ["numpy>=2.0", "no-such-package>=1"])
    (check,) = doctor._package_checks()
    assert check.status == "fail"
    assert 'pip install "no-such-package>=1"' in check.hint


def test_an_unwritable_cache_is_a_failure(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("")
    check = doctor._folder_check("cache", tmp_path / "file", "LUCARNA_CACHE")
    assert check.status == "fail"
    assert "LUCARNA_CACHE" in check.hint
    (tmp_path / "made").mkdir()
    (tmp_path / "made" / "blob").write_bytes(b"x" * 2**20)
    assert "1.0 MiB" in doctor._folder_check("cache", tmp_path / "made", "LUCARNA_CACHE").found


def test_display(monkeypatch: pytest.MonkeyPatch) -> None:
    assert not system_libraries.has_display({}, "linux")
    assert not system_libraries.has_display({"DISPLAY": ""}, "linux")
    assert system_libraries.has_display({"WAYLAND_DISPLAY": "wayland-0"}, "linux")
    assert system_libraries.has_display({}, "win32")


def test_missing_looks_only_where_it_makes_sense() -> None:
    assert missing(tests=True, platform="win32", present=lambda r: False) == []
    assert missing(tests=True, platform="linux", present=lambda r: True) == []
    absent = missing(platform="linux", present=lambda r: False)
    assert all(not r.test_only for r in absent)
    assert len(missing(tests=True, platform="linux", present=lambda r: False)) == len(REQUIREMENTS)


def test_install_hints_name_each_family() -> None:
    some = [r for r in REQUIREMENTS if r.name in {"libEGL.so.1", "libGL.so.1"}]
    assert install_hint(some, "debian") == "sudo apt-get install libegl1 libgl1"
    assert install_hint(some, "arch") == "sudo pacman -S --needed libglvnd"
    assert [line.split(":")[0] for line in install_hint(some, "").splitlines()] == [
        "Debian, Ubuntu",
        "Fedora, RHEL",
        "Arch",
    ]
    assert packages(REQUIREMENTS, "fedora")[0] == "libglvnd-egl"


@pytest.mark.parametrize(
    ("text", "family"),
    [
        ('ID=ubuntu\nID_LIKE="debian"\n', "debian"),
        ("ID=debian\n", "debian"),
        ('ID="rocky"\nID_LIKE="rhel centos fedora"\n', "fedora"),
        ("ID=arch\n", "arch"),
        ("ID=manjaro\nID_LIKE=arch\n", "arch"),
        ("ID=void\n", ""),
    ],
)
def test_distribution(tmp_path: Path, text: str, family: str) -> None:
    (tmp_path / "os-release").write_text(text)
    assert distribution(tmp_path / "os-release") == family
    assert distribution(tmp_path / "none") == ""


def test_drivers_are_found_by_their_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system_libraries, "has_library", lambda soname: False)
    assert not has_driver(tmp_path)
    (tmp_path / "usr/lib/x86_64-linux-gnu/dri").mkdir(parents=True)
    (tmp_path / "usr/lib/x86_64-linux-gnu/dri/swrast_dri.so").write_bytes(b"")
    assert has_driver(tmp_path)


def test_the_command_prints_json(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "examine", lambda: doctor.Report([doctor.Check("a", "ok", "b")], {"device": "x"}))
    monkeypatch.setattr(command, "font_check", lambda: doctor.Check("font", "ok", "c"))
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    assert command.run(parser.parse_args(["--json"])) == 0
    assert json.loads(capsys.readouterr().out)["checks"][0]["name"] == "a"
    assert command.run(SimpleNamespace(json=False)) == 0  # type: ignore[arg-type]  # a test double
    assert capsys.readouterr().out == "ok    a     b\nok    font  c\n"


@pytest.fixture
def no_font(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    cjk_font.cache_clear()
    monkeypatch.setattr("editor.fonts.KNOWN", {})
    monkeypatch.setattr("editor.fonts._by_fontconfig", lambda: None)
    yield
    cjk_font.cache_clear()


@pytest.mark.usefixtures("no_font")
def test_without_a_chinese_font_it_says_what_to_do(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("LUCARNA_FONT", raising=False)
    check = command.font_check()
    assert check.status == "warn"
    assert "LUCARNA_FONT" in check.hint
    cjk_font.cache_clear()
    monkeypatch.setenv("LUCARNA_FONT", str(tmp_path / "gone.ttf"))
    assert "gone.ttf, which is not there" in command.font_check().found
    (tmp_path / "broken.ttf").write_bytes(b"no font")
    cjk_font.cache_clear()
    monkeypatch.setenv("LUCARNA_FONT", str(tmp_path / "broken.ttf"))
    assert "cannot be read as a font" in command.font_check().found


@pytest.mark.usefixtures("no_font")
def test_a_font_without_the_glyphs_is_told_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    import imgui_bundle

    roboto = Path(imgui_bundle.__file__).parent / "assets/fonts/Roboto/Roboto-Regular.ttf"
    assert lacking(roboto, 0, "Undo") == ""
    assert lacking(roboto, 0, "Undo 撤销") == "撤销"
    monkeypatch.setenv("LUCARNA_FONT", str(roboto))
    check = command.font_check()
    assert check.status == "warn"
    assert f"lacks {command.SAMPLE}" in check.found


@pytest.mark.gl
def test_the_real_machine(gl_device: Any) -> None:
    """With a GL device at hand, asking it directly agrees."""
    _, described = doctor._device_checks(lambda: SimpleNamespace(caps=gl_device.caps, release=lambda: None))  # type: ignore[arg-type, return-value]  # a test double
    assert described is not None
    assert described["device"] == gl_device.caps.device
