"""Pruned against unpruned: the raw floats and the bytes of two frames of one scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.framegraph.compiled import LeftOut
from engine.render.facts import SceneFacts
from engine.render.lighting import PATHS
from tests.pruning.scenes import SIZE, SceneSpec, build
from tests.support.stage import Stage


@dataclass(frozen=True)
class Pictures:
    """One frame each way: `hdr` f4[h,w,4] as it came, `color` u1[h,w,4]; what the frame knew and left out."""

    hdr: NDArray[np.float32]
    color: NDArray[np.uint8]
    facts: SceneFacts
    left_out: tuple[LeftOut, ...]


def take(stage: Stage, spec: SceneSpec, folder: Path, *, force_all: bool = False) -> Pictures:
    """Build the scene and render it."""
    return shoot(stage, spec, build(stage, spec, folder), force_all=force_all)


def shoot(stage: Stage, spec: SceneSpec, camera: Any, *, force_all: bool) -> Pictures:
    settings = {
        "samples": spec.samples, "view": spec.view, "shadows": spec.shadows, "shadow_filter": spec.shadow_filter,
        "ambient_occlusion": spec.ambient_occlusion, "ao_radius": 0.5, "gi": spec.gi, "gi_steps": 6,
        "reflections": spec.reflections,
        "bloom": spec.bloom, "auto_exposure": spec.auto_exposure, "antialias": spec.antialias,
        "depth_of_field": spec.depth_of_field, "focus": 0.5, "sensor": 200.0,
        "planar_mirrors": spec.planar_mirrors, "refraction": spec.refraction,
        "taa_frames": 2, "shadow_floor": spec.shadow_floor,
        "shadow_size": 64, "shadow_cascades": 2, "local_shadows": spec.local_shadows, "local_shadow_size": 256,
        "force_all": force_all, "translucent_shadows": spec.translucent_shadows,
        "path": spec.path, "alpha_to_coverage": spec.cutouts_smooth,
    }  # fmt: skip
    frame = stage.runtime.render(stage.view(SIZE, camera, **settings), hdr=True)
    assert frame.hdr is not None
    hdr = np.asarray(frame.hdr.read(), np.float32).copy()
    # a frame that nobody asked linear output of leaves one pass more out
    plain = stage.runtime.render(stage.view(SIZE, camera, **settings))
    return Pictures(hdr, np.asarray(plain.color.read(), np.uint8).copy(), plain.facts, tuple(plain.graph.left_out))


def pruned_equals_forced(stage: Stage, spec: SceneSpec, folder: Path) -> Pictures:
    """Raises AssertionError where leaving out changes a bit; returns the pruned pictures."""
    camera = build(stage, spec, folder)
    pruned = shoot(stage, spec, camera, force_all=False)
    forced = shoot(stage, spec, camera, force_all=True)
    assert not forced.left_out, f"left out in spite of force_all: {[item.name for item in forced.left_out]}"
    assert all(item.reason for item in pruned.left_out)
    names = [item.name for item in pruned.left_out]
    _same_bits(pruned.hdr, forced.hdr, f"linear picture with {names} left out")
    _same_bits(pruned.color, forced.color, f"picture with {names} left out")
    return pruned


def paths_agree(stage: Stage, spec: SceneSpec, folder: Path) -> None:
    """Raises AssertionError where a render path makes another picture than the forward one; a scene without local
    lights gets one."""
    if not {"point", "spot", "rectangle", "disk", "profile"} & set(spec.lights):
        spec = replace(spec, lights=(*spec.lights, "point"))
    camera = build(stage, spec, folder)
    paths = PATHS if spec.samples == 1 else ("forward", "forward-plus")
    pictures = [shoot(stage, replace(spec, path=path), camera, force_all=False) for path in paths]
    for path, picture in zip(paths[1:], pictures[1:], strict=True):
        _same_bits(picture.hdr, pictures[0].hdr, f"linear picture by {path}")
        _same_bits(picture.color, pictures[0].color, f"picture by {path}")


def _same_bits(pruned: NDArray[Any], forced: NDArray[Any], what: str) -> None:
    differs = (pruned.view(f"u{pruned.itemsize}") != forced.view(f"u{forced.itemsize}")).any(axis=-1)
    if differs.any():
        y, x = (int(i[0]) for i in np.nonzero(differs))
        raise AssertionError(
            f"{what}: {np.count_nonzero(differs)} pixels differ from the one with everything, "
            f"first ({x}, {y}): {pruned[y, x].tolist()} and {forced[y, x].tolist()}"
        )
