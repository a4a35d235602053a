"""What is said of effects by `--explain` and `inspect`: which level of a technique is drawn and why, what stands in for
roles that an effect has not."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from engine.gpu.types import Caps
from engine.materials.effect import Effect
from engine.materials.requirements import AUTO, LEVELS
from engine.materials.roles import ABSENT
from engine.materials.technique import Technique
from engine.materials.variant import Variant


def level_lines(variants: Iterable[Variant]) -> list[str]:
    """A line for each technique that was drawn at one of several levels, or at none."""
    found = {}
    for variant in variants:
        if variant.level_reason not in ("", "the only one"):
            wanted = "" if variant.request.level == AUTO else f" ({variant.request.level} wanted)"
            key = f"level of {variant.request.effect} {variant.request.role}{wanted}"
            found[key] = f"{key}: {variant.level or 'none'}, {variant.level_reason}"
    return sorted(found.values())


def role_lines(effects: Iterable[Effect]) -> list[str]:
    """A line for each role that an effect has no technique for: what happens to its surfaces."""
    return [
        f"{effect.name} has no technique for {role}: what it draws {ABSENT[role]}"
        for effect in sorted(effects, key=lambda effect: effect.name)
        for role in ABSENT
        if role not in effect.techniques
    ]


def technique_rows(effect: Effect, caps: Caps | None = None) -> Iterator[dict[str, object]]:
    """role, level, pass, stages, state and requirements of every pass of every level, for `inspect`. `chosen`: which
    level a device with `caps` draws (None: one that can do all), and why."""
    for role, technique in effect.techniques.items():
        chosen, why = technique.at(AUTO, caps)
        for name in LEVELS:
            level = technique.levels.get(name)
            if level is not None:
                yield from _rows(role, level, why if level is chosen else "")


def _rows(role: str, technique: Technique, why: str) -> Iterator[dict[str, object]]:
    for index, draw in enumerate(technique.passes):
        if draw.compute:
            yield {
                "role": role, "level": technique.level, "pass": draw.name or index + 1, **draw.stages(),
                "fills": [f"{slot} {form}" for slot, form in technique.outputs.items()],
                "size": "{} x {}".format(*technique.size), "requires": list(technique.requires),
                "defines": [f"{k}={v}" for k, v in draw.defines.items()], "chosen": why,
            }  # fmt: skip
            continue
        depth, raster = draw.depth, draw.raster
        states = ["no depth test"] * (not depth.test) + ["no depth write"] * (not depth.write)
        states += [f"depth {depth.compare}"] * (depth.compare != "gequal")
        states += ["stencil"] * (draw.stencil is not None) + [f"cull {raster.cull}"] * (raster.cull != "back")
        states += ["wireframe"] * (raster.fill == "wireframe") + [f"writes {draw.write_mask}"] * (
            draw.write_mask != "rgba"
        )
        yield {
            "role": role, "level": technique.level, "pass": draw.name or index + 1, **draw.stages(),
            "blend": draw.blend if isinstance(draw.blend, str) else "custom", "state": states,
            "requires": list(technique.requires), "defines": [f"{k}={v}" for k, v in draw.defines.items()],
            "chosen": why,
        }  # fmt: skip
