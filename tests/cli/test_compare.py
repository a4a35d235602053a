"""`lucarna compare`: two pictures, and one scene in two ways."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from engine.assets.samples.sample import make_sample, write_sample
from engine.report.image import load_png, save_png
from importers.cli.main import main


@pytest.fixture
def pictures(tmp_path: Path) -> tuple[Path, Path]:
    a = np.full((8, 12, 3), 100, np.uint8)
    b = a.copy()
    b[2, 3, 0] = 140
    for name, pixels in (("a", a), ("b", b)):
        save_png(tmp_path / f"{name}.png", pixels)
    return tmp_path / "a.png", tmp_path / "b.png"


def test_numbers_map_and_limits(pictures: tuple[Path, Path], tmp_path: Path, capsys) -> None:
    a, b = map(str, pictures)
    assert main(["compare", a, b, "--no-flip", "--json", "--out", str(tmp_path / "map.png")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["largest"], found["worst"], found["flip"], found["over"]) == (40, [3, 2], None, [])
    assert load_png(tmp_path / "map.png").any(axis=2).sum() >= 1
    assert main(["compare", a, b, "--no-flip", "--max-difference", "39"]) == 1
    assert "more than 39" in capsys.readouterr().out
    assert main(["compare", a, a]) == 0
    assert "equal in every pixel" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "says"),
    [(["a.png"], "one thing"), (["a.png", "b.png", "--a", "exposure=1"], "are for a scene"),
     (["a.png", "b.png", "--no-flip", "--max-flip", "1"], "needs FLIP")],
)  # fmt: skip
def test_nonsense_is_refused(words: list[str], says: str, capsys) -> None:
    assert main(["compare", *words]) == 2
    assert says in capsys.readouterr().err


def test_a_scene_by_two_paths_is_one_picture_and_another_exposure_another(tmp_path: Path, gl_device, capsys) -> None:
    scene = write_sample(make_sample("poles", lights=4), tmp_path)
    common = ["compare", str(scene), "--size", "48x32", "--set", "samples=1", "--no-flip", "--json"]
    assert main([*common, "--a", "path=forward", "--b", "path=deferred"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["largest"] == 0
    assert len(found["ms"]) == 2
    assert min(found["ms"]) > 0.0
    assert main([*common, "--b", "exposure=1", "--max-difference", "5"]) == 1
    assert json.loads(capsys.readouterr().out)["largest"] > 5
