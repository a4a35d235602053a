"""`lucarna inspect MATERIAL --brdf OUT.png`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.report.image import load_png
from engine.report.metrics import is_blank
from engine.report.plot_sheet import Plot, draw_sheet
from importers.cli.main import main

COAT = """name = "lack"
effect = "layered"
features = ["clearcoat", "masking_implicit"]
[params]
metallic = 0.0
roughness = 0.5
"""


@pytest.fixture
def material(tmp_path: Path) -> Path:
    path = tmp_path / "lack.material.toml"
    path.write_text(COAT, encoding="utf-8")
    return path


def test_draws_and_tells(material: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "lack.png"
    assert main(["inspect", str(material), "--brdf", str(out), "--incidence", "60"]) == 0
    told = capsys.readouterr().out
    assert "furnace error" in told
    assert "loses light at grazing" in told
    picture = load_png(out)
    assert not is_blank(picture)
    # one colour a part: diffuse, specular, coat
    colors = {tuple(c) for c in picture.reshape(-1, picture.shape[2])[:, :3].tolist()}
    assert {(47, 111, 176), (214, 134, 30), (70, 150, 80)} <= colors


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--brdf", "x.txt"], "writes a PNG"),
        (["--brdf", "x.png", "--incidence", "95"], "no angle"),
    ],
)
def test_mistakes(material: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], said: str) -> None:
    assert main(["inspect", str(material), *arguments]) == 2
    assert said in capsys.readouterr().err
    assert not Path("x.png").exists()


def test_what_has_no_lobe_is_told(material: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    material.write_text(
        COAT.replace('"layered"', '"toon"').replace('"clearcoat", "masking_implicit"', ""), encoding="utf-8"
    )
    assert main(["inspect", str(material), "--brdf", str(tmp_path / "x.png")]) == 2
    assert "no lobe" in capsys.readouterr().err
    assert not (tmp_path / "x.png").exists()


def test_a_line_lies_where_its_values_are() -> None:
    x = np.linspace(0.0, 90.0, 3)
    at = []
    for value in (0.25, 0.5, 0.75):
        sheet = draw_sheet("t", [Plot("p", [("a", x, np.full(3, value))], low=0.0, high=1.0)], columns=1)
        at.append(np.flatnonzero((sheet == (47, 111, 176)).all(axis=-1).sum(axis=1) > 100).mean())
    assert at[0] - at[1] == pytest.approx(at[1] - at[2], abs=1.5)
    assert at[0] > at[2] + 50
