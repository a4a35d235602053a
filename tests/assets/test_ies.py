"""IES files: each form of symmetry, factors, and what is wrong with bad ones, by line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from engine.assets.ies import parse_ies, read_ies
from engine.core.errors import FormatError, InputError
from engine.core.findings import Findings
from engine.scene.light_profiles import check_profiles

HEAD = "IESNA:LM-63-1995\n[TEST] 1\n[MANUFAC] Nobody\n[MORE] at all\nTILT=NONE\n"


def lamp(
    vertical: str = "0 90 180", horizontal: str = "0", candela: str = "100 100 100", head: str = HEAD,
    counts: str = "", kind: int = 1, multiplier: str = "1", ballast: str = "1",
) -> str:  # fmt: skip
    sizes = counts or f"{len(vertical.split())} {len(horizontal.split())}"
    return f"{head}1 1000 {multiplier} {sizes} {kind} 2 0 0 0\n{ballast} 1 20\n{vertical}\n{horizontal}\n{candela}\n"


def test_an_even_lamp_gives_four_pi_lumens_per_candela() -> None:
    profile = parse_ies(lamp())
    assert profile.flux() == pytest.approx(400.0 * math.pi, rel=1e-4)
    assert (profile.peak, profile.lumens, profile.watts, profile.version) == (100.0, 1000.0, 20.0, "1995")
    assert profile.labels == {"TEST": "1", "MANUFAC": "Nobody\nat all"}
    assert (profile.relative(8, 4) == 1.0).all()


def test_factors_multiply() -> None:
    assert parse_ies(lamp(multiplier="2.5", ballast="0.5")).peak == pytest.approx(125.0)


def test_absolute_photometry_has_no_lamp_lumens() -> None:
    assert parse_ies(lamp().replace("1 1000", "1 -1")).lumens == 0.0


def test_linear_between_angles_and_dark_outside() -> None:
    profile = parse_ies(lamp("0 45 90", candela="100 50 0"))
    assert profile.at(77.0, [0.0, 22.5, 45.0, 90.0, 91.0, 180.0]) == pytest.approx([100, 75, 50, 0, 0, 0])


@pytest.mark.parametrize(
    ("horizontal", "rows", "at", "expected"),
    [
        ("0 90", (10, 30), [0, 45, 90, 135, 180, 225, 270, 315], [10, 20, 30, 20, 10, 20, 30, 20]),
        ("0 180", (10, 30), [0, 90, 180, 270, 360], [10, 20, 30, 20, 10]),
        ("90 270", (10, 30), [90, 180, 270, 0, 45], [10, 20, 30, 20, 15]),
        ("0 120 240 360", (10, 20, 30, 10), [0, 60, 240, 300], [10, 15, 30, 20]),
        ("0 120 240", (10, 20, 30), [0, 60, 240, 300, 359.9999], [10, 15, 30, 20, 10]),
    ],
)
def test_symmetries(horizontal: str, rows: tuple[int, ...], at: list[float], expected: list[float]) -> None:
    profile = parse_ies(lamp("0 180", horizontal, "\n".join(f"{v} {v}" for v in rows)))
    assert profile.at(at, 30.0) == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize(
    ("first", "version"), [("IESNA91\n", "1991"), ("IESNA:LM-63-2002\n", "2002"), ("some lamp\n", "1986")]
)
def test_versions(first: str, version: str) -> None:
    assert parse_ies(lamp(head=f"{first}TILT=NONE\n")).version == version


def test_numbers_flow_over_lines_and_a_tilt_table_is_passed_over() -> None:
    notes = Findings()
    text = lamp(head="IESNA91\nTILT=INCLUDE\n1\n2\n0 90\n1 0.8\n").replace("0 90 180", "0\n90,\n180")
    assert parse_ies(text, "", notes).peak == 100.0
    assert [f.code for f in notes] == ["ies.tilt"]


@pytest.mark.parametrize(
    ("text", "complaint", "line"),
    [
        ("", "no TILT", 0),
        ("%PDF-1.4 nothing", "no TILT", 0),
        (lamp(kind=2), "type B", 6),
        (lamp(candela="100 100"), "ends within the candela", 10),
        (lamp(candela="100 x 100"), "'x' is no number", 10),
        (lamp(candela="100 -1 100"), "below 0", 10),
        (lamp(candela="100 nan 100"), "below 0", 10),
        (lamp(candela="0 0 0"), "dark", 10),
        (lamp("0 180 90"), "do not rise", 8),
        (lamp("0 90 270"), "leave 0 to 180", 8),
        (lamp("0 90", "10 50", "1 1 1 1"), "symmetry", 9),
        (lamp("0", candela="1"), "one vertical", 8),
        (lamp(counts="99999999 1"), "number of vertical", 6),
        (lamp(counts="3.5 1"), "number of vertical", 6),
        (lamp(counts="nan 1"), "number of vertical", 6),
    ],
)
def test_bad_files_say_what_and_where(text: str, complaint: str, line: int) -> None:
    with pytest.raises(FormatError, match=complaint) as caught:
        parse_ies(text, "lamp.ies")
    place = caught.value.where
    assert "lamp.ies" in str(place)
    if line:
        assert f":{line}" in str(place)


def test_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_ies(tmp_path / "none.ies")
    (tmp_path / "a.ies").write_bytes(lamp().encode("latin-1").replace(b"Nobody", b"L\xe4mp"))
    assert np.isfinite(read_ies(tmp_path / "a.ies").candela).all()


def test_what_lights_name_is_checked(tmp_path: Path) -> None:
    (tmp_path / "good.ies").write_text(lamp(), "utf-8")
    (tmp_path / "bad.ies").write_text(lamp(kind=3), "utf-8")
    findings = Findings()
    check_profiles(["good.ies", "", "bad.ies", "gone.ies", "bad.ies"], tmp_path, findings)
    assert [(f.code, Path(f.where.file).name) for f in findings] == [
        ("light.profile", "bad.ies"), ("light.profile", "gone.ies"),
    ]  # fmt: skip
