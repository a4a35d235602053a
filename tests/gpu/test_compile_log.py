from __future__ import annotations

from pathlib import Path

import pytest

from engine.core.errors import ShaderError
from engine.gpu.compile_log import LogEntry, compile_error, parse_log
from engine.gpu.preprocess import flatten
from engine.gpu.types import ComputePipelineDesc, Device, RenderPipelineDesc, ShaderSource

SOURCE = ShaderSource(
    "fragment",
    "#define STAGE_FRAGMENT 1\nvoid main() {\n\tcolor = albdo * 2.0;\n}\n",
    (("<defines>", 1), ("lib/surface.glsl", 40), ("lib/surface.glsl", 41), ("lib/surface.glsl", 42)),
)


@pytest.mark.parametrize(
    ("log", "entry"),
    [
        ("0:3(10): error: `albdo' undeclared", LogEntry("error", 3, 10, "`albdo' undeclared")),
        ("0:3(10): warning: `x' used uninitialized", LogEntry("warning", 3, 10, "`x' used uninitialized")),
        (
            '0(3) : error C1008: undefined variable "albdo"',
            LogEntry("error", 3, 0, 'C1008: undefined variable "albdo"'),
        ),
        ("0(3) : warning C7050: might be used", LogEntry("warning", 3, 0, "C7050: might be used")),
        ("ERROR: 0:3: 'albdo' : undeclared identifier", LogEntry("error", 3, 0, "'albdo' : undeclared identifier")),
    ],
)
def test_the_three_forms(log: str, entry: LogEntry) -> None:
    assert parse_log(f"Fragment shader failed to compile with the following errors:\n{log}\n\0") == [entry]


@pytest.mark.parametrize(
    "log",
    [
        "0:3(10): error: `albdo' undeclared\n0:9(1): error: no such line",
        "0:3(10): error: no name is told",
        '0(3) : error C1008: undefined variable "albdo"',
        "ERROR: 0:3: 'albdo' : undeclared identifier\nERROR: 1 compilation errors.  No code generated.",
    ],
)
def test_error_has_file_line_column_source_and_caret(log: str) -> None:
    text = str(compile_error(SOURCE, log, "surface"))
    assert text.startswith("lib/surface.glsl:41:10: ")
    lines = text.splitlines()
    assert lines[1] == "     color = albdo * 2.0;"
    assert lines[2].index("^") == lines[1].index("albdo")


def test_warnings_alone_and_unknown_forms_are_shown_whole() -> None:
    assert "internal error 7" in str(compile_error(SOURCE, "internal error 7"))
    assert "said nothing" in str(compile_error(ShaderSource("vertex", ""), ""))


def test_many_errors_are_cut() -> None:
    log = "\n".join(f"0:3({n + 1}): error: e{n}" for n in range(12))
    assert str(compile_error(SOURCE, log)).endswith("and 4 more")


def test_the_driver_s_own_message_maps_to_the_included_file(gl_device: Device, tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib/broken.glsl").write_text(
        "// fine\n\nfloat twice(float x) {\n    return x * undefined_factor;\n}\n"
    )
    (tmp_path / "a.frag").write_text('#include "lib/broken.glsl"\nout vec4 c;\nvoid main() { c = vec4(twice(1.0)); }\n')
    fragment = flatten(tmp_path / "a.frag", "fragment", search=[tmp_path], defines={"A": 1, "B": 2})
    vertex = ShaderSource("vertex", "void main() { gl_Position = vec4(0.0); }")
    with pytest.raises(ShaderError) as caught:
        gl_device.render_pipeline(RenderPipelineDesc("broken", vertex, fragment))
    where = caught.value.where
    assert (where.file, where.line) == (str(tmp_path / "lib/broken.glsl"), 4)
    assert where.column == 16
    text = str(caught.value)
    assert "undefined_factor" in text
    assert "    return x * undefined_factor;" in text
    assert "fragment stage of 'broken'" in text


def test_link_errors_name_the_pipeline(gl_device: Device) -> None:
    vertex = ShaderSource("vertex", "void main() { gl_Position = vec4(0.0); }")
    fragment = ShaderSource("fragment", "in vec3 absent; out vec4 c; void main() { c = vec4(absent, 1.0); }")
    with pytest.raises(ShaderError, match=r"'unlinked' does not link.*absent"):
        gl_device.render_pipeline(RenderPipelineDesc("unlinked", vertex, fragment))
    with pytest.raises(ShaderError, match=r"does not link|does not compile"):
        gl_device.compute_pipeline(ComputePipelineDesc("empty", ShaderSource("compute", "void main() {}")))
