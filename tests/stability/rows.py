"""The catalogue of numeric extremes, row by row: which test guards it, or what it still waits for.

A test names its row with `@covers("brdf.ggx-small-alpha")`; rows guarded by a unit test of their own package name that
test. `python -m tests.stability` prints the table; test_rows.py fails where a row has neither a test nor a reason.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

F = TypeVar("F", bound=Callable[..., object])
HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]


@dataclass(slots=True)
class Row:
    """`case`: what is extreme. `elsewhere`: tests in other packages (`path::name`). `waits`: why there is none yet."""

    key: str
    case: str
    elsewhere: tuple[str, ...] = ()
    waits: str = ""
    tests: list[str] = field(default_factory=list)


def covers(*keys: str) -> Callable[[F], F]:
    """Marks a test as the guard of these rows. A misspelt key fails at import."""
    unknown = [key for key in keys if key not in BY_KEY]
    assert not unknown, f"no such row: {unknown}"
    return lambda function: function


def scan() -> list[Row]:
    """All rows with the tests of this folder that cover them, read from the sources without running anything."""
    rows = {row.key: Row(row.key, row.case, row.elsewhere, row.waits) for row in ROWS}
    for file in sorted(HERE.glob("test_*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not isinstance(node, ast.FunctionDef):
                continue
            for mark in node.decorator_list:
                if isinstance(mark, ast.Call) and isinstance(mark.func, ast.Name) and mark.func.id == "covers":
                    for key in mark.args:
                        assert isinstance(key, ast.Constant)
                        rows[str(key.value)].tests.append(f"tests/stability/{file.name}::{node.name}")
    return list(rows.values())


def markdown() -> str:
    """The table: row, what is extreme, its tests or what it waits for."""
    lines = ["| row | case | guarded by |", "|---|---|---|"]
    for row in scan():
        guards = [f"`{name}`" for name in (*row.tests, *row.elsewhere)]
        lines.append(f"| {row.key} | {row.case} | {', '.join(guards) or 'waits: ' + row.waits} |")
    return "\n".join(lines)


_SHADOWS = "tests/render/"
_RENDER = "tests/render/"
_AO = _RENDER + "test_ambient_occlusion.py::"
_ANIMATION = "tests/animation/"

_QUAT = "tests/math/test_quat.py::test_slerp_"

ROWS = (
    # --- BRDF ---
    Row("brdf.ggx-small-alpha", "GGX in float32 as alpha goes to 1e-4"),
    Row("brdf.ggx-least-alpha", "alpha 0, 1e-8, .002, .0079: finite, and falling with alpha at the peak"),
    Row("brdf.roughness-of-a-file", "roughness 0, -1, not a number, from a file or an editor"),
    Row("brdf.ggx-half-arithmetic", "D, F, V computed in half floats, alpha from .0079"),
    Row("brdf.beckmann", "Beckmann at n.h = 0"),
    Row("brdf.blinn-phong", "Blinn-Phong with exponents up to 1e6"),
    Row("brdf.grazing", "n.v = n.l = 0 and 1e-8: finite and reciprocal"),
    Row("brdf.fresnel-range", "v.h below 0 and above 1"),
    Row("brdf.half-of-opposites", "normalize(0): light straight against the view"),
    Row("brdf.light-at-distance-0", "a light on the surface; a spot whose cones are equal"),
    Row("brdf.energy", "white furnace, 1/pi of Lambert", ("tests/render/test_analytic.py::test_lambert_under_a_sun",)),
    # --- formats, not a number, determinism ---
    Row("format.one-bad-pixel", "one texel of an input is not a number, infinite, negative, huge or denormal"),
    Row("format.half-store", "values beyond what a half float holds; rounding of the store"),
    Row("format.half-sums", "ten thousand small terms: no sum sticks, as one in half floats would"),
    Row(
        "format.half-history", "a running mean of many frames comes to its limit",
        (_RENDER + "test_taa.py::test_it_converges_to_the_supersampled_picture",
         _RENDER + "test_ambient_occlusion_frames.py::test_before_the_filter_it_is_the_mean_of_its_frames",
         _RENDER + "test_gi_motion.py::test_a_still_camera_calms_down"),
    ),
    Row("format.no-infinities-in-data", "1/0 as a sentinel, inf - inf"),
    Row("format.integer-noise", "noise from fract(sin())"),
    Row("format.transcendentals", "exp, log, pow, sqrt, atan of this device against float64"),
    Row("format.table-filter", "a table's error between its texels"),
    Row("format.light-order", "the order of lights changes the sum by an ulp at most"),
    Row("format.who-made-it", "which pass made the first NaN or infinity, and in which pixel"),
    # --- depth ---
    Row(
        "depth.near-and-far", "near 1e-3, far 1e6: two planes a thousandth apart at 1 to 1e5 m",
        ("tests/math/test_projection_frustum_bounds.py::test_depth_tells_near_planes_apart_at_any_distance",),
    ),
    Row("depth.reversed-float", "the device really gives reversed 32-bit depth"),
    Row(
        "shadow.splits", "cascade splits of 1e-3 to 1e6 m, of nothing, of one point",
        (_SHADOWS + "shadows/test_shadow_splits.py::test_cuts_rise_strictly_whatever_the_range",
         _SHADOWS + "shadows/test_shadow_splits.py::test_a_range_that_no_view_should_have_and_the_same_clamped",
         _SHADOWS + "shadows/test_shadow_fit.py::test_extreme_scenes_give_finite_cascades"),
    ),
    Row(
        "shadow.acne", "planes from 0 to 89 degrees; a cube that touches its shadow",
        (_SHADOWS + "test_shadows.py::test_a_tilted_plane_does_not_shadow_itself",
         _SHADOWS + "test_shadows.py::test_a_cube_on_the_floor_touches_its_shadow"),
    ),
    Row(
        "shadow.shimmer", "cascades crawl with the camera, edges flicker with the light",
        (_SHADOWS + "test_shadows.py::test_moving_the_camera_by_less_than_a_texel_moves_no_shadow",
         _SHADOWS + "test_shadow_extremes.py::test_a_seventh_of_a_texel_changes_no_shadow",
         _SHADOWS + "test_shadow_motion.py::test_a_light_that_moves_does_not_make_edges_flicker"),
    ),
    Row(
        "shadow.range", "near 1e-3, a ground of 1e6 m; a sun in the zenith, below, on the horizon; 1 pixel; 8 maps",
        (_SHADOWS + "test_shadow_extremes.py::test_near_of_a_millimetre_and_a_ground_of_a_thousand_kilometres",
         _SHADOWS + "test_shadow_extremes.py::test_a_sun_straight_above_below_and_on_the_horizon",
         _SHADOWS + "test_shadow_extremes.py::test_nothing_and_one_pixel",
         _SHADOWS + "test_shadow_motion.py::test_any_number_of_cascades_however_split_shows_one_shadow"),
    ),
    Row(
        "shadow.lamps", "a lamp inside a caster; scaled and moved scenes; panes before a lamp in them",
        (_SHADOWS + "test_local_shadows.py::test_a_lamp_inside_a_body_lights_nothing_outside",
         _SHADOWS + "test_local_shadows.py::test_far_from_the_origin_and_at_any_scale",
         _SHADOWS + "test_local_tints.py::test_size_and_place_of_the_world_do_not_matter"),
    ),
    Row(
        "shadow.variance", "variance of a flat depth; two casters before a receiver",
        (_SHADOWS + "shadows/test_shadow_moments.py::test_a_flat_plane_is_lit",
         _SHADOWS + "shadows/test_shadow_moments.py::test_light_leaks_of_two_casters_are_those_known"),
    ),
    Row(
        "shadow.exponents", "exponents that overflow, in single and half precision; depths 0 and 1",
        (_SHADOWS + "shadows/test_shadow_moments.py::test_exponents_are_kept_below_overflow",
         _SHADOWS + "shadows/test_shadow_moments.py::test_esm_at_the_ends_of_depth"),
    ),
    # --- transforms and animation ---
    Row("pose.slerp-small-angle", "1e-7 radians to a half turn", (_QUAT + "is_constant_speed",)),
    Row(
        "pose.antipodal", "q and -q; a half turn apart",
        (_QUAT + "half_turn_is_unit", _ANIMATION + "test_blend.py::test_the_row_antipodal_double_cover"),
    ),
    Row("pose.bad-quaternion", "length 1e-30 to 1e30, zero, not a number"),
    Row("pose.bad-camera", "a pose that is not finite or flat, a lens that cannot be, a near plane of 1e-12 to 1e30 m"),
    Row(
        "pose.blend-weights", "weights that sum to 0, negative ones, not a number",
        (_ANIMATION + "test_blend.py::test_the_row_weights_sum_0_is_the_rest_pose",
         _ANIMATION + "test_blend.py::test_the_row_negative_weights_count_as_0"),
    ),
    Row("pose.morphs", "morph weights that are not a number, infinite, 1e30"),
    Row(
        "pose.skin-weights", "sums other than 1, more than 8 influences, none",
        ("tests/importers/test_topology_skin_quantize.py::test_influences_of_bad_sums_are_counted",
         "tests/importers/test_topology_skin_quantize.py::test_weights_always_sum_to_one"),
    ),
    Row("pose.singular-scale", "scales (1,1,0), (-1,1,1), 1e-9 to 1e9, 1e4 to 1"),
    Row("pose.bad-bone", "one key that is not a number: everything else is bit-equal"),
    Row(
        "pose.odd-clips", "0 keys, 1 key, equal keys, t = -1e9, 1e12, not a number",
        (_ANIMATION + "test_sampler.py::test_the_row_t_huge_or_not_a_number_holds_the_ends",
         _ANIMATION + "test_animator.py::test_the_row_zero_duration_and_time_not_a_number"),
    ),
    Row(
        "pose.cubic-spline", "against a float64 Hermite spline",
        ("tests/animation/test_sample.py::test_every_channel_against_float64",),
    ),
    Row(
        "pose.far-from-the-origin", "scene and camera moved by 1e6 m; skins and shadows with them",
        ("tests/render/test_skinning.py::test_a_skinned_mesh_far_from_the_origin_looks_the_same",
         "tests/render/test_shadows.py::test_shadows_far_from_the_origin"),
    ),
    Row("pose.tiny-and-huge", "scene, camera and lights scaled by 1e-4 and 1e4"),
    Row(
        "pose.no-tangents", "triangles without area, no uv, tangents of length 0",
        ("tests/importers/test_tangents.py::test_degenerate_input_gives_finite_unit_orthogonal_frames",),
    ),
    Row("pose.mirrored", "a mirrored scene is the mirrored picture"),
    # --- light, sizes ---
    Row("light.empty-scene", "no light, no mesh: exactly the clear colour, nothing drawn"),
    Row("light.very-many", "thousands of lights at one point equal one that is as bright"),
    Row("light.bad-values", "negative, not a number, 1e8; radius 0; cones of 0 and 180 degrees"),
    Row("light.order", "lights and nodes in any order"),
    Row("light.tile-depth", "tiles of sky only, of sky and one body, of many depths"),
    Row("light.tile-discontinuities", "tiles that hold near and far: thin poles, lights in the air between them"),
    Row("light.tile-edges", "tiles of any size at odd sizes of the picture"),
    Row("light.path-agreement", "deferred = tiled = forward+"),
    Row(
        "light.occlusion", "Alchemy, horizon-based: border, any field of view, radius below a pixel, above the screen",
        (_AO + "test_a_plane_hides_nothing_of_itself", _AO + "test_no_radius_is_too_small_or_too_large",
         _AO + "test_beside_a_wall", _AO + "test_sixteen_places_are_enough_beside_a_wall",
         _AO + "test_a_ball_hides_the_ground_that_it_stands_on",
         _AO + "test_what_stands_before_a_wall_hides_no_more_than_itself"),
    ),
    Row(
        "light.layers", "an empty second layer",
        (_RENDER + "test_gi.py::test_a_second_layer_that_is_empty_changes_nothing",),
    ),
    Row(
        "light.bounces", "light again and again: no growth without end, nothing after a light goes out or a cut",
        (_RENDER + "test_gi.py::test_bounces_never_grow_without_end",
         _RENDER + "test_gi.py::test_a_closed_box_comes_to_its_limit",
         _RENDER + "test_gi_motion.py::test_a_light_that_goes_out_is_gone",
         _RENDER + "test_gi_motion.py::test_a_cut_forgets"),
    ),
    Row("light.all-at-once", "occlusion, bounces, mirrors, shadows and TAA together at the ends of scenes and sizes"),
    Row("light.reflection", "camera on, under, along the mirror"),
    Row("light.refraction", "total internal reflection, posts before the water"),
    Row("facts.flicker", "a fact that is true in every other frame: graphs do not come and go, no bit changes"),
    Row("size.odd", "1x1, 17x31, one pixel wide"),
    Row("size.resize", "sizes of 1 to 40 pixels in any order"),
    Row("size.many-vertices", "more than 65535 vertices in a mesh"),
    Row("size.many-bones", "8192 bones"),
    Row("size.double-resolution", "twice the resolution, averaged, is the same picture"),
)  # fmt: skip

BY_KEY = {row.key: row for row in ROWS}
