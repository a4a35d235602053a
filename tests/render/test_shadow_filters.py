"""Blurred shadow maps in the picture: what leaks, what is kept between frames, what they cost where nobody asks."""

from __future__ import annotations

import math

import numpy as np
import pytest

from engine.assets.primitives import plane
from engine.assets.scene import LightAsset
from engine.math.transform import look_at
from engine.render.camera import Camera

pytestmark = pytest.mark.gl

SIZE = (96, 96)
KINDS = ("esm", "vsm", "evsm2", "evsm4", "msm")


@pytest.fixture
def two_casters(stage, surface):
    """The sun 45 degrees high in -X. A card 2 m over a floor darkens x from -1 to 3; one at 4 m ends at 1.5, where the
    camera looks down: truth is dark all over."""
    stage.look(
        kind="none", background="color", background_color=(0, 0, 0), sun_illuminance=2.0,
        sun_azimuth=-math.pi / 2, sun_elevation=math.pi / 4,
    )  # fmt: skip
    grey = surface(base_color=(0.5, 0.5, 0.5, 1), metallic=0.0, specular=0.0)
    stage.add(plane(12.0), grey)
    stage.add(plane(3.0), grey, (-4.0, 4.0, 0.0))
    stage.add(plane(4.0), grey, (-1.0, 2.0, 0.0))
    return down(1.5, 0.25)


def down(x: float, half: float) -> Camera:
    """Straight down on the square of that half width around x."""
    return Camera(look_at((x, 6.0, 0.0), (x, 0.0, 0.0), (0.0, 0.0, -1.0)), ymag=half, znear=0.1, zfar=20.0)


def under(stage, camera, **settings) -> np.ndarray:
    """What is left of the light: truth is 0."""
    lit = stage.hdr(SIZE, camera, shadows=False, samples=1)[..., 0]
    seen = stage.hdr(SIZE, camera, samples=1, shadow_size=256, shadow_softness=4.0, **settings)[..., 0]
    assert (lit > 0.0).all()
    return seen / lit


def test_light_leaks_through_two_casters(stage, two_casters) -> None:
    """As the moments' known answers say: variance alone leaks, a warp or four moments much less, and what is taken
    for none takes the rest; comparing depths leaks nothing."""
    worst = {f: under(stage, two_casters, shadow_filter=f, shadow_leak=0.0).max() for f in KINDS}
    assert worst["vsm"] > 0.1
    for filter in ("esm", "evsm2", "evsm4", "msm"):
        assert worst[filter] < 0.1 * worst["vsm"], filter
    assert under(stage, two_casters, shadow_filter="vsm", shadow_leak=0.3).max() == 0.0
    assert under(stage, two_casters, shadow_filter="vogel16").max() == 0.0


def frame(stage, camera, **settings):
    return stage.runtime.renderer.render(stage.runtime.scene, stage.view((24, 24), camera, **settings))


def test_no_pass_where_the_filter_compares_depths(stage, two_casters) -> None:

    def reason(**settings) -> str:
        left = frame(stage, two_casters, **settings).graph.left_out
        return next(item.reason for item in left if item.name == "shadow_moments")

    assert reason(shadow_filter="pcf") == "the shadows' filter compares depths"
    assert reason(shadow_filter="msm", shadows=False) == "no shadows of the sun"
    for unused in ({"shadow_exponent": 3.0}, {"shadow_leak": 0.5}, {"shadow_precision": "half"}):
        plain = frame(stage, two_casters, shadow_filter="vogel8")
        facts, bits = plain.facts, np.array(plain.color.read())
        changed = frame(stage, two_casters, shadow_filter="vogel8", **unused)
        assert changed.facts == facts
        assert (np.array(changed.color.read()) == bits).all()


def test_maps_at_rest_are_not_blurred_again(stage, two_casters) -> None:
    device = stage.runtime.device

    def dispatches(**settings) -> int:
        frame(stage, two_casters, shadow_filter="evsm4", shadow_cascades=2, **settings)
        return device.counters.dispatches

    first = dispatches()
    assert first >= 2
    assert dispatches() == 0
    assert dispatches(shadow_softness=3.0) == first  # another blur
    assert dispatches(shadow_softness=3.0, shadow_exponent=10.0) == first


@pytest.mark.parametrize("filter", ["vsm", "evsm4", "msm"])
def test_half_numbers_keep_a_floor_lit(stage, two_casters, filter) -> None:
    """With the exponent at its limit for them: no darker where nothing casts, and dark in the core."""
    camera = down(4.5, 1.0)
    lit = stage.hdr(SIZE, camera, shadows=False)[..., 0]
    seen = stage.hdr(SIZE, camera, shadow_filter=filter, shadow_precision="half")[..., 0]
    assert (seen == lit).all()


def test_softness_is_the_disc_s(stage, two_casters) -> None:
    """The blur is as wide as the disc of lookups: the same edge."""
    camera = down(3.0, 0.5)
    options = {"shadow_size": 256, "shadow_softness": 4.0, "samples": 1}
    disc = stage.hdr(SIZE, camera, shadow_filter="vogel16", **options)[..., 0]
    assert 0.1 < (disc < 0.5 * disc.max()).mean() < 0.9
    # the exponential ones count a slope's own depths, msm is lifted: their edges lie nearer to what casts
    blurred = stage.hdr(SIZE, camera, shadow_filter="vsm", shadow_leak=0.0, **options)[..., 0]
    assert np.abs(blurred - disc).mean() < 0.06 * disc.max()


@pytest.mark.parametrize("filter", ["poisson24", "evsm4"])
def test_all_paths_and_the_forced_frame_agree(stage, two_casters, filter) -> None:
    stage.lamp(LightAsset("point", (1.0, 0.6, 0.3), 6.0, 6.0, casts_shadow=True), (2.5, 1.0, 0.5))
    camera = Camera(look_at((5.0, 3.0, 4.0), (1.0, 0.3, 0.0)), 0.8, znear=0.05)
    options = {"shadow_filter": filter, "shadow_size": 128, "local_shadow_size": 256}
    truth = stage.hdr((48, 40), camera, path="forward", **options)
    assert np.abs(truth - stage.hdr((48, 40), camera, path="forward", shadows=False, **options)).max() > 0.05
    for path in ("deferred", "tiled-deferred", "forward-plus"):
        assert np.array_equal(stage.hdr((48, 40), camera, path=path, **options), truth), path
    assert np.array_equal(stage.hdr((48, 40), camera, path="forward", force_all=True, **options), truth)
