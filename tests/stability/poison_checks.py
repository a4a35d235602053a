"""The poison test of one pass, as a function: also run against passes and shaders with planted bugs."""

from __future__ import annotations

import numpy as np

from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.framegraph.passes import WHOLE_PICTURE, Pass
from engine.gpu.types import Device
from engine.render.view import View
from tests.support import poison
from tests.support.stage import Stage, front_camera, surface

SIZE = (24, 20)
#: on the sphere, on the glass, on the background
TEXELS = ((12, 10), (4, 16), (0, 0))
#: what the lighting may leave in a target: the sanitised range, and coverage
HIGHEST = 32000.0


def full_stage(device: Device) -> Stage:
    """A bit of everything, so that no pass has nothing to do."""
    stage = Stage(device, kind="uniform", color=(0.4, 0.5, 0.6), sun_illuminance=2.0, background="environment")
    stage.add(uv_sphere(rings=8, segments=16), surface(metallic=0.5, roughness=0.3, emissive=(0.1, 0.0, 0.0)))
    stage.add(cube(0.3), surface(base_color=(0.2, 0.8, 0.3, 1.0), metallic=0.0, roughness=0.8), (0.4, 0.3, 0.2))
    stage.add(card(0.5), surface("transparent", base_color=(1, 0, 0, 0.5)), (-0.3, -0.2, 0.6))
    stage.lamp(LightAsset("point", intensity=0.5), (0.5, 0.6, 0.8))
    return stage


#: passes that leave the picture as it is unless they are asked for, forced or not: how to ask
ASKED: dict[str, dict[str, object]] = {
    "taa": {"antialias": "taa", "taa_frames": 1},
    "depth_of_field": {"depth_of_field": True, "focus": 1.0, "sensor": 300.0},
}


def full_view(stage: Stage, samples: int = 1, path: str = "auto", name: str = "") -> View:
    camera = front_camera(0.6, SIZE[0] / SIZE[1])
    more = ASKED.get(name, {})
    return stage.view(
        SIZE, camera, samples=samples, shadow_size=32, shadow_cascades=1, force_all=True, path=path, **more
    )  # fmt: skip


def has_declared_reach(item: Pass) -> None:
    assert item.reach is not None, (
        f"pass {item.name!r} does not say how far one texel of its inputs reaches: set `reach` in its class "
        "(pixels; 0 = its own pixel only, WHOLE_PICTURE = anywhere)"
    )


def pass_contains_poison(stage: Stage, item: Pass, value: float, samples: int = 1, path: str = "auto") -> int:
    """Plant `value` in each input of `item`, one texel at a time; returns how many plants were tried."""
    has_declared_reach(item)
    assert item.reach is not None
    view = full_view(stage, samples, path, item.name)
    clean = poison.shoot(stage.runtime, view, item.name)
    assert any(p.name == item.name for p in clean.graph.passes), f"pass {item.name!r} did not run"
    again = poison.shoot(stage.runtime, view, item.name)
    assert (poison.bits(again.hdr) == poison.bits(clean.hdr)).all(), "two equal frames differ: nothing can be compared"
    read, over = poison.inputs_of(clean.graph, item.name)
    count = 0
    for name in (*read, *over):
        desc = clean.graph.texture(name).desc
        seen_alike = (desc.width, desc.height) == SIZE
        for x, y in TEXELS if seen_alike else _spread(desc.width, desc.height):
            shot = poison.shoot(stage.runtime, view, item.name, (name, x, y, value))
            where = f"pass {item.name!r}, {value} in {name!r} at ({x}, {y})"
            count += 1
            if name in read:
                for output, image in shot.outputs.items():
                    _in_range(image, f"{where}: output {output!r}")
            # a map of another size than the view (shadows, tables) may be looked into from anywhere
            own_reach = item.reach if seen_alike else WHOLE_PICTURE
            for output, image in shot.outputs.items():
                _elsewhere_equal(image, clean.outputs[output], x, y, own_reach, f"{where}: output {output!r}")
            # the whole frame after it: finite everywhere, and untouched outside what all later passes may reach
            _in_range(shot.hdr, f"{where}: linear picture")
            reach = own_reach + sum(p.reach or 0 for p in _from(clean.graph.passes, item.name)[1:])
            _elsewhere_equal(shot.hdr, clean.hdr, x, y, reach, f"{where}: linear picture")
            _elsewhere_equal(shot.color, clean.color, x, y, reach, f"{where}: picture")
    for output, image in clean.outputs.items():
        _in_range(image, f"pass {item.name!r}: output {output!r}")
    return count


def _spread(width: int, height: int) -> list[tuple[int, int]]:
    """Some texels all over a map."""
    return [(int((i + 0.5) * width / 3), int((j + 0.5) * height / 3)) for i in range(3) for j in range(3)]


def _from(passes, name: str) -> list[Pass]:  # type: ignore[no-untyped-def]  # a sequence of Pass
    names = [p.name for p in passes]
    return list(passes[names.index(name) :])


def _in_range(image: np.ndarray, what: str) -> None:
    if image.dtype.kind != "f":
        return
    values = image.astype(np.float64)
    assert np.isfinite(values).all(), f"{what} is not finite in {np.count_nonzero(~np.isfinite(values))} values"
    assert values.min() >= 0.0, f"{what} has {values.min():g}"
    assert values.max() <= HIGHEST, f"{what} has {values.max():g}"


def _elsewhere_equal(image: np.ndarray, clean: np.ndarray, x: int, y: int, reach: int, what: str) -> None:
    apart = poison.outside(image.shape, x, y, reach)
    differs = (poison.bits(image) != poison.bits(clean)).any(axis=-1) & apart
    assert not differs.any(), f"{what} changed in {np.count_nonzero(differs)} pixels out of reach ({reach} px)"
