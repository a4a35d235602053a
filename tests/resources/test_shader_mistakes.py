"""Every mistake of the table keeps the last good picture, names the right line, and is gone once it is mended."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.gpu.types import Device
from tests.shader_mistakes import MISTAKES, Said, run


@pytest.fixture(scope="module")
def said(gl_device: Device, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Said]:
    return {row.mistake.name: row for row in run(gl_device, tmp_path_factory.mktemp("mistakes"))}


@pytest.mark.gl
@pytest.mark.parametrize("name", [mistake.name for mistake in MISTAKES])
def test_mistake(said: dict[str, Said], name: str) -> None:
    row = said[name]
    assert row.picture_stays, "the last good picture is lost"
    assert row.mended, "something remains after it was mended"
    assert row.message
    file, line = [*row.place.split(":"), "0"][:2]
    assert Path(file).as_posix() == row.mistake.file
    if row.mistake.line and "cycle" not in row.message and "unexpected '{'" not in row.message:
        # the driver says where it noticed, which is the line of the mistake or the next one
        assert int(line) - row.line in (0, 1, 2), row
