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


#: driver -> (what it says of an unknown name, of a missing `;`, of a preprocessor mistake, a warning beside them)
LOGS = {
    "Mesa": (
        "0:3(10): error: `albdo' undeclared\n0:3(10): error: operands to arithmetic operators must be numeric\n",
        "0:4(1): error: syntax error, unexpected '}', expecting ',' or ';'\n",
        "0:3(2): preprocessor error: syntax error, unexpected HASH_TOKEN\n",
        "0:2(5): warning: `x' used uninitialized\n",
    ),
    "NVIDIA": (
        '0(3) : error C1503: undefined variable "albdo"\n0(3) : error C1503: undefined variable "albdo"\n',
        "0(4) : error C0000: syntax error, unexpected '}', expecting ',' or ';' at token \"}\"\n",
        "0(3) : error C0105: Syntax error in #if\n",
        "0(2) : warning C7050: \"x\" might be used before being initialized\n",
    ),
    "Intel": (
        "ERROR: 0:3: 'albdo' : undeclared identifier \nERROR: 0:3: 'assign' :  cannot convert from 'float' to "
        "'3-component vector of float'\nERROR: 2 compilation errors.  No code generated.\n\n",
        "ERROR: 0:4: '}' : syntax error syntax error\n",
        "ERROR: 0:3: '' : syntax error: #if\n",
        "WARNING: 0:2: 'x' : used before it is set\n",
    ),
    "AMD": (
        "Fragment shader failed to compile with the following errors:\n"
        "ERROR: 0:3: error(#143) Undeclared identifier: albdo\n"
        "ERROR: 0:3: error(#216) Vector field selection out of range \"xyz\"\n"
        "ERROR: error(#273) 2 compilation errors.  No code generated\n",
        "ERROR: 0:4: error(#132) Syntax error: \"}\" parse error\n",
        "ERROR: 0:3: error(#76) Syntax error: unexpected tokens following #if\n",
        "WARNING: 0:2: warning(#402) Implicit truncation of vector\n",
    ),
    "ANGLE": (
        "ERROR: 0:3: 'albdo' : undeclared identifier\nERROR: 0:3: '' : compilation terminated\n",
        "ERROR: 0:4: '}' : syntax error\n",
        "ERROR: 0:3: 'if' : unexpected token after conditional expression\n",
        "WARNING: 0:2: 'x' : variable used before it was initialized\n",
    ),
    "Apple": (
        "ERROR: 0:3: Use of undeclared identifier 'albdo'\n",
        "ERROR: 0:4: '}' : syntax error: syntax error\n",
        "ERROR: 0:3: '' : syntax error: #if\n",
        "WARNING: 0:2: Overflow in implicit constant conversion\n",
    ),
}  # fmt: skip
KNOWN = ShaderSource(
    "fragment",
    SOURCE.text.replace("void main() {", "void main() { vec3 albedo = vec3(1.0), other = albedo;"),
    SOURCE.lines,
)


@pytest.mark.parametrize("driver", LOGS)
def test_an_unknown_name_is_found_under_the_driver_s_words(driver: str) -> None:
    error = compile_error(KNOWN, LOGS[driver][3] + LOGS[driver][0] + "\0", "surface")
    text = str(error)
    assert text.startswith("lib/surface.glsl:41:10: ")
    lines = text.splitlines()
    assert lines[1] == "     color = albdo * 2.0;"
    assert lines[2].index("^") == lines[1].index("albdo")
    assert "did you mean 'albedo'?" in text
    assert "generated" not in text
    assert "terminated" not in text
    assert text.count("albdo") - text.count("= albdo") == 1, "told once"


@pytest.mark.parametrize("driver", LOGS)
def test_the_line_of_other_mistakes(driver: str) -> None:
    name, syntax, directive, warning = LOGS[driver]
    assert str(compile_error(SOURCE, syntax).where).startswith("lib/surface.glsl:42")
    assert str(compile_error(SOURCE, directive).where).startswith("lib/surface.glsl:41")
    assert [(e.kind, e.line) for e in parse_log(warning)] == [("warning", 2)]
    assert [(e.kind, e.line) for e in parse_log(warning + name)][:2] == [("warning", 2), ("error", 3)]


def test_a_line_that_the_driver_does_not_know() -> None:
    assert parse_log("ERROR: 0:? : '' : syntax error: #line\n") == [LogEntry("error", 0, 0, "'' : syntax error: #line")]
    assert "syntax error: #line" in str(compile_error(SOURCE, "ERROR: 0:? : '' : syntax error: #line\n"))


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
