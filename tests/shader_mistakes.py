"""What a mistake in an effect, a shader or a material says: `python -m tests.shader_mistakes` prints the table.

Each mistake is made in a project of its own that was drawn before, and taken back; `run` gives what was seen, so that
tests can look at it too.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from engine.app.framing import frame_bounds
from engine.app.headless import render_image
from engine.app.runtime import Runtime
from engine.assets.lmesh import write_lmesh
from engine.assets.material import MaterialAsset
from engine.assets.material_toml import write_material
from engine.assets.primitives import cube
from engine.assets.scene import EnvironmentAsset, MeshRef, NodeAsset, SceneAsset
from engine.assets.scene_json import write_scene
from engine.core.paths import shaders_dir
from engine.gpu import open_device
from engine.gpu.types import Device
from engine.render.settings import RenderSettings
from engine.render.view import View

FRAG, VERT = "shaders/effects/surface.frag", "shaders/effects/surface.vert"
EFFECT, MATERIAL = "shaders/effects/surface.effect.toml", "paint.material.toml"
INCLUDE, TONE = "shaders/lib/brdf.glsl", "shaders/passes/tone_map.frag"
LAST, SHADE = "vec4(sanitise(color), 1.0)", "vec3 color = shade("


@dataclass(frozen=True, slots=True)
class Mistake:
    """`old` in `file` is replaced by `new` (bytes: the whole file). The error must name `line` of `file`; 0: any."""

    name: str
    file: str
    old: str
    new: str | bytes
    line: bool = True


MISTAKES = (
    Mistake("syntax error: a bracket is missing", FRAG, LAST, "vec4(sanitise(color), 1.0"),
    Mistake(
        "syntax error in an include", INCLUDE, "float antialiased_roughness(", "float float antialiased_roughness("
    ),
    Mistake("type error", FRAG, SHADE, "float color = shade("),
    Mistake("unknown variable", FRAG, LAST, "vec4(sanitise(colour), 1.0)"),
    Mistake("unknown parameter", FRAG, "s.metallic = m.metallic;", "s.metallic = m.metalic;"),
    Mistake("unknown function", FRAG, LAST, "vec4(sanitize(color), 1.0)"),
    Mistake("wrong sampler type", FRAG, LAST, "texture(t_base_color_map, vec2(0.5))"),
    Mistake("missing include", FRAG, "lib/view.glsl", "lib/veiw.glsl"),
    Mistake("include cycle", INCLUDE, "\n\n", '\n#include "lib/lights.glsl"\n'),
    Mistake("a file includes itself", INCLUDE, "\n\n", '\n#include "lib/brdf.glsl"\n'),
    Mistake("include without quotes", FRAG, '"lib/view.glsl"', "lib/view.glsl"),
    Mistake("#version in a shader", FRAG, '#include "lib/view.glsl"', "#version 330"),
    Mistake("vertex shader: syntax error", VERT, "void main()", "void main("),
    Mistake("pass shader: syntax error", TONE, "void main()", "void main("),
    Mistake("effect: unknown key", EFFECT, "\ndoc = ", "\ndok = "),
    Mistake("effect: not TOML", EFFECT, 'type = "color4"', "type = color4"),
    Mistake("effect: unknown parameter type", EFFECT, 'type = "color4"', 'type = "colour4"'),
    Mistake("effect: default out of range", EFFECT, "default = 0.5", "default = 1.5"),
    Mistake("effect: shader file is not there", EFFECT, '"effects/surface.frag"', '"effects/sruface.frag"'),
    Mistake("effect: unknown blend", EFFECT, 'blend = "opaque"', 'blend = "opaqe"'),
    Mistake("effect: implied by an unknown texture", EFFECT, 'implied_by = "normal_map"', 'implied_by = "nromal_map"'),
    Mistake("effect: extends itself", EFFECT, 'name = "surface"', 'name = "surface"\nextends = "surface"'),
    Mistake("effect: unknown key of a state", EFFECT, 'raster = { cull = "back" }', 'raster = { cul = "back" }'),
    Mistake("effect: unknown word of a state", EFFECT, 'compare = "gequal"', 'compare = "gequel"'),
    Mistake("effect: stencil operation", EFFECT, 'blend = "opaque"', 'stencil = { pass = "incremnt" }'),
    Mistake("effect: unknown state group", EFFECT, 'blend = "opaque"', 'states = ["marked"]'),
    Mistake("effect: unknown colour target", EFFECT, 'blend = "opaque"', 'targets.colour = { write_mask = "r" }'),
    Mistake("effect: unknown level", EFFECT, 'blend = "opaque"', 'levels.ultra = { fragment = "effects/toon.frag" }'),
    Mistake("effect: unknown requirement", EFFECT, 'level = "low"', 'requires = ["tesselation"]'),
    Mistake("effect: control stage without evaluation", EFFECT, 'level = "low"', 'tess_control = "effects/a.tesc"'),
    Mistake("effect: compute stage in a technique", EFFECT, 'level = "low"', 'compute = "effects/a.comp"'),
    Mistake("effect: file of a geometry stage is not there", EFFECT, 'level = "low"', 'geometry = "effects/a.geom"'),
    Mistake("effect: macro in small letters", EFFECT, 'level = "low"', "defines = { shells = 3 }"),
    Mistake("effect: unknown vertex stream", EFFECT, 'level = "low"', 'streams = ["uv"]'),
    Mistake("effect: unknown sampler group", EFFECT, 'space = "srgb"', 'space = "srgb"\nsampler = "soft"'),
    Mistake("effect: condition on nothing", EFFECT, 'type = "color4"', 'type = "color4"\nwhen = "metalic > 0"'),
    Mistake("effect: colour with a wrong digit", EFFECT, "default = [1.0, 1.0, 1.0, 1.0]", 'default = "#ffgg00"'),
    Mistake("material: colour with too few digits", MATERIAL, "base_color = ", 'base_color = "#ff80f" # '),
    Mistake("material: name of no colour", MATERIAL, "base_color = ", 'base_color = "ornage" # '),
    Mistake("material: colour in an unknown space", MATERIAL, "base_color = ", "base_color = { p3 = [1, 0, 0] } # "),
    Mistake("material: parent is not there", MATERIAL, "effect = ", 'parent = "b.material.toml"\neffect = '),
    Mistake("material: is its own parent", MATERIAL, "effect = ", 'parent = "paint.material.toml"\neffect = '),
    Mistake("material: parent is no path", MATERIAL, "effect = ", "parent = 3\neffect = "),
    Mistake("material: unknown level", MATERIAL, "effect = ", 'level = "ultra"\neffect = '),
    Mistake("material: unknown parameter", MATERIAL, "metallic", "metalic"),
    Mistake("material: value out of range", MATERIAL, "metallic = 0.0", "metallic = 7.0"),
    Mistake("material: unknown key", MATERIAL, "effect = ", "efect = "),
    Mistake("material: unknown effect", MATERIAL, 'effect = "surface"', 'effect = "surfcae"', line=False),
    Mistake("material: unknown feature", MATERIAL, "\n[params]", 'features = ["unlitt"]\n[params]'),
    Mistake("infinite include, behind a condition", INCLUDE, "\n\n", '\n#if 1\n#include "lib/lights.glsl"\n#endif\n'),
    Mistake("it compiles but writes NaN", FRAG, LAST, "vec4(log(-dot(color, color) - 1.0))"),
    Mistake("shader is not text", FRAG, "", b"\xff\xfe\x00void", line=False),
    Mistake("shader is empty", FRAG, "", b"", line=False),
)


@dataclass(frozen=True, slots=True)
class Said:
    """What came of a mistake: `place` (file:line:column), `message` with caret and hint; whether the picture stayed,
    and whether all was as before once it was mended. `line`: where the mistake was made."""

    mistake: Mistake
    place: str
    message: str
    line: int
    picture_stays: bool
    mended: bool


def run(device: Device, folder: Path, mistakes: tuple[Mistake, ...] = MISTAKES) -> Iterator[Said]:
    """Make each mistake in a project in `folder` and say what happens."""
    runtime, view = _project(device, folder)
    try:
        good = np.array(render_image(runtime, view)[0])
        clock = 0.0
        for mistake in mistakes:
            path = folder / mistake.file
            sound = path.read_bytes()
            clock += 1.0
            _write(path, _wrong(sound, mistake))
            runtime.hot_reload.poll(clock)
            stays = bool((np.array(render_image(runtime, view)[0]) == good).all())
            problems = runtime.hot_reload.problems
            clock += 1.0
            _write(path, sound)
            runtime.hot_reload.poll(clock)
            mended = not runtime.hot_reload.problems
            mended &= bool((np.array(render_image(runtime, view)[0]) == good).all())
            text = sound.decode("utf-8")
            line = text.count("\n", 0, text.index(mistake.old)) + 1 if mistake.old else 0
            if not problems:
                yield Said(mistake, "", "", line, stays, mended)
                continue
            first = problems[0]
            hint = f" ({first.hint})" if first.hint else ""
            where = str(first.where).replace(f"{folder}{os.sep}", "")
            yield Said(mistake, where, first.message.replace(f"{folder}{os.sep}", "") + hint, line, stays, mended)
    finally:
        runtime.close()


def _project(device: Device, folder: Path) -> tuple[Runtime, View]:
    shutil.copytree(shaders_dir(), folder / "shaders")
    write_lmesh(folder / "a.lmesh", [cube()], {})
    params: dict[str, Any] = {"base_color": (0.8, 0.2, 0.1, 1.0), "metallic": 0.0, "roughness": 0.4}
    write_material(folder / MATERIAL, MaterialAsset("paint", params=params))
    text = (folder / MATERIAL).read_text(encoding="utf-8")
    (folder / MATERIAL).write_text(text, encoding="utf-8")
    node = NodeAsset("cube", mesh=MeshRef("a.lmesh", 0, "cube", [MATERIAL]))
    look = EnvironmentAsset("uniform", color=(0.7, 0.7, 0.7), background="color", sun_illuminance=0.0)
    write_scene(folder / "a.scene.json", SceneAsset("a", [node], environment=look))
    runtime = Runtime(device, profile=False)
    runtime.open(folder / "a.scene.json")
    camera = frame_bounds(np.full(3, -0.5), np.full(3, 0.5), 1.0)
    return runtime, View(camera, 48, 48, RenderSettings(samples=1))


def _wrong(sound: bytes, mistake: Mistake) -> bytes:
    if isinstance(mistake.new, bytes):
        return mistake.new
    assert mistake.old.encode() in sound, f"{mistake.name}: {mistake.file} has no {mistake.old!r}"
    return sound.replace(mistake.old.encode(), mistake.new.encode(), 1)


def _write(path: Path, data: bytes) -> None:
    path.write_bytes(data)
    info = path.stat()
    os.utime(path, ns=(info.st_atime_ns, info.st_mtime_ns + 1_000_000))


def main() -> int:
    device = open_device("gl")
    with tempfile.TemporaryDirectory() as folder:
        rows = list(run(device, Path(folder)))
    device.release()
    print("| mistake | line named | message | last good picture |\n|---|---|---|---|")
    for said in rows:
        words = said.message.split("\n")
        hint = said.message[said.message.rindex(" (") :] if said.message.endswith("?)") and len(words) > 1 else ""
        kept = "stays" if said.picture_stays else "LOST"
        print(f"| {said.mistake.name} | `{said.place or 'none'}` | {words[0]}{hint} | {kept} |")
    wrong = [said for said in rows if not (said.place and said.picture_stays and said.mended)]
    return 1 if wrong else 0


if __name__ == "__main__":
    raise SystemExit(main())
