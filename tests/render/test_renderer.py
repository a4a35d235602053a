"""What a frame does: nothing for an empty scene, the same with everything forced, few calls for many objects."""

from __future__ import annotations

import numpy as np
import pytest

from engine.assets.primitives import card, cube, uv_sphere


@pytest.mark.gl
def test_an_empty_scene_is_exactly_the_background(stage) -> None:
    stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0.25, 0.5, 0.75))
    picture = stage.hdr()
    assert (picture == np.array([0.25, 0.5, 0.75, 1.0], np.float32)).all()


@pytest.mark.gl
@pytest.mark.parametrize("samples", [1, 4])
@pytest.mark.parametrize("kind", ["none", "uniform", "studio"])
@pytest.mark.parametrize("sun", [0.0, 2.0])
def test_pruned_and_forced_pictures_are_bit_equal(stage, surface, kind, sun, samples) -> None:
    stage.look(kind=kind, sun_illuminance=sun, background="color")
    stage.add(uv_sphere(), surface(base_color=(0.8, 0.5, 0.2, 1), metallic=0.5, roughness=0.3))
    stage.add(card(3.0), surface(base_color=(0.4, 0.4, 0.4, 1), metallic=0.0), (0.0, 0.0, -1.0))
    pruned, forced = stage.ldr(samples=samples), stage.ldr(samples=samples, force_all=True)
    assert len(np.unique(pruned)) > (2 if kind != "none" or sun else 0)
    assert (pruned == forced).all()


@pytest.mark.gl
def test_passes_are_left_out_with_a_reason(stage) -> None:
    stage.look(kind="none", sun_illuminance=0.0, background="color")
    view = stage.view()
    frame = stage.runtime.render(view)
    left_out = {item.name for item in frame.graph.left_out}
    assert left_out == {
        "shadow_cascades", "shadow_moments", "shadow_tints", "local_shadows", "local_moments", "local_tints",
        "depth_prepass", "ambient_occlusion",
        "deep_gbuffer", "radiosity", "bounces", "indirect", "reflections", "sky", "scene_color", "scene_front",
        "planar_reflections", "transparent",
        "light_heat", "shadow_maps", "auto_exposure", "bloom", "resolve", "fxaa",
        "motion", "motion_late", "taa", "smaa", "depth_of_field", "shadow_floor",
    }  # fmt: skip
    assert all(item.reason for item in frame.graph.left_out)


@pytest.mark.gl
def test_each_fact_changes_the_picture(stage, surface) -> None:
    """The negative of pruning: switching a fact on must be seen, or `needs` would be wrong."""
    stage.look(kind="none", sun_illuminance=0.0, background="color")
    stage.add(uv_sphere(), surface(base_color=(0.8, 0.5, 0.2, 1), metallic=0.0, roughness=0.3))
    dark = stage.ldr()
    environment = stage.runtime.scene.environment
    environment.sun_illuminance = 2.0
    sun = stage.ldr()
    environment.kind = "uniform"
    lit = stage.ldr()
    background = stage.ldr(background="environment")
    for a, b in ((dark, sun), (sun, lit), (lit, background)):
        assert (a != b).any()


@pytest.mark.parametrize("count", [10, 1000])
def test_api_calls_do_not_grow_with_the_objects(null_stage, surface, count) -> None:
    residency = null_stage.runtime.residency
    mesh = residency.add_meshes([cube()])[0]
    from pathlib import Path

    materials = [residency.add_material(surface(base_color=(i / 8, 0.5, 0.5, 1)), Path()) for i in range(8)]
    nodes = null_stage.runtime.scene.nodes
    positions = np.random.default_rng(1).normal(size=(count, 3))
    rows = nodes.add_many(
        [f"n{i}" for i in range(count)], np.full(count, -1), positions,
        np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)), np.ones((count, 3)),
    )  # fmt: skip
    null_stage.runtime.add_instances([(int(r), mesh, 0, materials[i % 8]) for i, r in enumerate(rows)])
    null_stage.runtime.update()
    view = null_stage.view()
    frame = null_stage.runtime.render(view)
    assert frame.stats.counters["instances"] == count
    assert frame.stats.counters["triangles"] == 12 * count
    for _ in range(2):
        nodes.set_translation(rows, positions + 0.01)
        frame = null_stage.runtime.render(view)
    assert frame.stats.counters["api_calls"] < 60
    assert frame.stats.counters["draws"] <= 4


def test_a_still_scene_uploads_next_to_nothing(null_stage, surface) -> None:
    for i in range(50):
        null_stage.add(cube(), surface(base_color=(0.5, 0.5, 0.5, 1)), (float(i), 0.0, 0.0))
    view = null_stage.view()
    null_stage.runtime.render(view)
    frame = null_stage.runtime.render(view)
    assert frame.stats.counters["bytes_uploaded"] < 2048  # the view block and the passes' parameters


def test_hidden_nodes_are_not_drawn(null_stage, surface) -> None:
    node = null_stage.add(cube(), surface(base_color=(0.5, 0.5, 0.5, 1)))
    null_stage.add(cube(), surface(base_color=(0.5, 0.5, 0.5, 1)), (2.0, 0.0, 0.0))
    view = null_stage.view()
    assert null_stage.runtime.render(view).stats.counters["instances"] == 2
    null_stage.runtime.scene.nodes.set_visible([node], False)
    assert null_stage.runtime.render(view).stats.counters["instances"] == 1
