"""What the texture viewer reads and shows: known numbers in, known pixels out; a look into the middle of a frame."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from editor.picture_files import PictureFiles, read_picture
from editor.texture_sources import ALL_FACES, Source, list_sources, read
from editor.texture_view import cross, depth_range, linear, magnified, normals, not_numbers, picture
from engine.assets.dds import write_dds
from engine.assets.texture import TextureAsset
from engine.core.errors import LucarnaError
from engine.report.image import save_png

GREY = np.full((2, 3, 4), 188, np.uint8)  # sRGB 188 is 0.5029 linear (IEC 61966-2-1)


def test_srgb_comes_back_linear_and_alpha_as_it_is() -> None:
    values = linear(np.array([[[188 / 255, 0.0, 1.0, 0.25]]], np.float32))[0, 0]
    assert values == pytest.approx((0.50289, 0.0, 1.0, 0.25), abs=1e-4)


def test_luminance_and_normals_are_shown() -> None:
    green = np.array([[[0.0, 0.5, 0.0, 1.0]]], np.float32)
    assert picture(green, "luma", 0.0, 0.0, 1.0, encode=False)[0, 0, :3].tolist() == [91, 91, 91]  # 0.3576 of 255
    up = np.array([[[0.5, 0.5]]], np.float32)
    assert picture(up, "normal", 3.0, 0.0, 0.1, encode=True)[0, 0, :3].tolist() == [128, 128, 255]
    assert normals(np.array([[[0.6, 0.0]]], np.float32), signed=True)[0, 0] == pytest.approx((0.6, 0.0, 0.8))


def test_depth_is_shown_from_the_nearest_to_the_farthest_that_was_drawn() -> None:
    values = np.array([[[0.0], [0.2], [0.6]]], np.float32)
    assert depth_range(values) == pytest.approx((0.2, 0.6))
    assert depth_range(values * 0.0) == (0.0, 1.0)
    assert depth_range(np.full((1, 1, 1), 0.5, np.float32)) == (0.0, 0.5)


def test_texels_that_are_no_numbers_are_counted() -> None:
    values = np.zeros((2, 2, 3), np.float32)
    values[0, 0, 1], values[1, 1, 0], values[1, 1, 1] = np.nan, np.inf, -np.inf
    assert not_numbers(values) == (1, 1)


def test_magnified_texels_are_squares() -> None:
    pixels = np.arange(2 * 2 * 4, dtype=np.uint8).reshape(2, 2, 4)
    shown = magnified(pixels, (1.0, 0.0), 2.0, (6, 4))
    assert shown.shape == (4, 6, 4)
    assert (shown[:, 0] == 0).all(), "beside the picture"
    assert (shown[0:2, 1:3] == pixels[0, 0]).all()
    assert (shown[2:4, 3:5] == pixels[1, 1]).all()


def test_a_cube_unfolds_as_a_cross() -> None:
    faces = [np.full((1, 1, 1), float(i + 1), np.float32) for i in range(6)]
    assert cross(faces)[..., 0].tolist() == [[0, 3, 0, 0], [2, 5, 1, 6], [0, 4, 0, 0]]


def session_with(sources: Any = None) -> Any:
    return SimpleNamespace(image=SimpleNamespace(frame=None), document=None)


def test_an_image_file_is_read_behind_the_window(tmp_path: Path) -> None:
    file = tmp_path / "wall_color.png"
    save_png(file, GREY)
    found = read_picture(file)
    assert (found.srgb, found.bits, found.pixels.shape) == (True, 8, (2, 3, 4))
    rough = tmp_path / "wall_roughness.png"
    save_png(rough, GREY)
    assert not read_picture(rough).srgb, "by its name it is no colour"
    files = PictureFiles()
    while files.get(file) is None:
        pass
    level = read(session_with(), Source("file", str(file)), 0, 0, files)
    assert level is not None
    assert level.values[0, 0, :3] == pytest.approx((0.50289,) * 3, abs=1e-4)
    (tmp_path / "no.png").write_bytes(b"nothing")
    while (bad := files.get(tmp_path / "no.png")) is None:
        pass
    assert bad.problem
    with pytest.raises(LucarnaError):
        read(session_with(), Source("file", str(tmp_path / "no.png")), 0, 0, files)
    assert [s.kind for s in list_sources(session_with(), file)] == ["file"]


def test_faces_and_mips_of_a_stored_cube(tmp_path: Path, gl_device: Any) -> None:
    data = [[np.full((2 >> m, 2 >> m, 4), 40 * face + m, np.uint8).tobytes() for m in (0, 1)] for face in range(6)]
    file = tmp_path / "sky.dds"
    write_dds(file, TextureAsset("rgba8", 2, 2, data, cube=True))
    device = gl_device
    session = SimpleNamespace(image=SimpleNamespace(frame=None), document=None, device=device)
    session.device_frame = lambda: _frame(device)
    files = PictureFiles()
    while files.get(file) is None:
        pass
    source = Source("file", str(file))
    face = read(session, source, 1, 2, files)
    assert face is not None
    assert (face.desc.kind, face.desc.mips, face.values.shape) == ("cube", 2, (1, 1, 4))
    assert face.values[0, 0, 0] == pytest.approx(81 / 255)
    whole = read(session, source, 0, ALL_FACES, files)
    assert whole is not None
    assert whole.values.shape == (6, 8, 4)
    assert whole.values[2, 4, 0] == pytest.approx(0.0), "+X, to the right of the front"
    assert whole.values[2, 2, 0] == pytest.approx(160 / 255), "+Z, in front"


class _frame:
    def __init__(self, device: Any) -> None:
        self.device = device

    def __enter__(self) -> None:
        self.device.begin_frame()

    def __exit__(self, *_: object) -> None:
        self.device.end_frame()
