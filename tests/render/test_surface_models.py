"""Surface models in pictures: every path draws the same, the default is the standard surface, layers keep energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.assets.material import MaterialAsset
from engine.assets.primitives import card, cube, uv_sphere
from engine.assets.scene import LightAsset
from engine.gpu.types import Device
from engine.render.lighting import PATHS
from tests.support.stage import Stage, front_camera, surface

pytestmark = pytest.mark.gl
SIZE = (60, 40)
CAMERA = front_camera(0.9, 1.5)
LAYERS: dict[str, dict[str, Any]] = {
    "clearcoat": {"roughness": 0.7, "base_color": (0.6, 0.05, 0.05, 1)},
    "sheen": {"roughness": 0.9, "sheen_color": (0.5, 0.5, 0.9), "sheen_roughness": 0.4},
    "anisotropy": {"metallic": 1.0, "roughness": 0.3, "anisotropy": 0.9},
    "iridescence": {"metallic": 1.0, "roughness": 0.2, "base_color": (0.6, 0.6, 0.6, 1)},
    "transmission": {
        "roughness": 0.1,
        "thickness": 0.4,
        "attenuation_distance": 0.5,
        "attenuation_color": (0.4, 0.9, 0.5),
    },
}
TERMS = (
    ("distribution_beckmann", "masking_walter", "fresnel_dielectric"), ("fresnel_conductor", "masking_cook_torrance"),
)  # fmt: skip


def of(effect: str, *features: str, queue: str = "opaque", **params: Any) -> MaterialAsset:
    return MaterialAsset(
        effect, effect=effect, queue=queue, features=list(features), params={"metallic": 0.0, **params}
    )


def lamps(stage: Stage) -> None:
    for x in (-0.8, 0.0, 0.9):
        stage.lamp(LightAsset("point", (1.0, 0.9, 0.8), 1.5, 3.0), (x, 0.7, 0.9))
    # a rectangle too: it takes another way through the model
    stage.lamp(LightAsset("rect", (0.5, 0.6, 1.0), 3.0, 4.0), (0.0, 0.2, 1.2))


def everything(stage: Stage) -> None:
    stage.look(kind="uniform", color=(0.2, 0.25, 0.3), sun_illuminance=0.7)
    together = [("clearcoat", "sheen", "anisotropy"), ("iridescence", "transmission")]
    materials = [of("layered", *names, **{k: v for n in names for k, v in LAYERS[n].items()}) for names in together]
    materials += [of("microfacet", *features, roughness=0.4) for features in TERMS]
    materials += [of("blinn_phong", exponent=50.0), of("toon"), of("uv_checker"), of("wireframe"), surface()]
    for i, material in enumerate(materials):
        stage.add(uv_sphere(0.22, 12, 24), material, (-1.05 + 0.52 * (i % 5), 0.5 - 0.5 * (i // 5), 0.0))
    stage.add(card(4.0), surface(base_color=(0.5, 0.4, 0.3, 1), metallic=0.0, roughness=0.8), (0, 0, -0.4))
    lamps(stage)


def bits(picture: NDArray[np.float32]) -> NDArray[np.uint32]:
    return picture.view(np.uint32)


def test_every_path_draws_the_same(stage: Stage) -> None:
    everything(stage)
    truth = stage.hdr(SIZE, CAMERA, path="forward").copy()
    assert not stage.runtime.renderer.programs.errors
    assert np.isfinite(truth).all()
    for path in PATHS[1:]:
        apart = (bits(stage.hdr(SIZE, CAMERA, path=path)) != bits(truth)).any(axis=-1)
        assert not apart.any(), f"{path}: {apart.sum()} pixels"


def test_nothing_left_out_changes_the_picture(stage: Stage) -> None:
    everything(stage)
    lean = stage.hdr(SIZE, CAMERA).copy()
    full = stage.hdr(SIZE, CAMERA, force_all=True)
    assert (bits(lean) == bits(full)).all()


def test_scenes_without_models_have_no_pass_for_them(stage: Stage) -> None:
    stage.add(uv_sphere(), surface())
    lamps(stage)
    stage.hdr(SIZE, CAMERA, path="tiled-deferred")
    frame = stage.runtime.renderer.render(stage.runtime.scene, stage.view(SIZE, CAMERA, path="tiled-deferred"))
    why = {left.name: left.reason for left in frame.graph.left_out}
    assert why["scene_color"] == "nothing shows what is behind it"
    assert "opaque_forward" in why


def test_default_terms_are_those_of_the_standard_surface(stage: Stage) -> None:
    """Same numbers by another program: what differs is rounding, and what the standard one packs for lamps."""
    pictures = []
    for effect in ("surface", "microfacet", "layered"):
        stage.look(kind="uniform", color=(0.3, 0.3, 0.3), sun_illuminance=2.0)
        stage.add(uv_sphere(), of(effect, base_color=(0.8, 0.4, 0.2, 1), roughness=0.35, metallic=0.4))
        stage.lamp(LightAsset("point", (1, 1, 1), 3.0), (0.5, 1.0, 1.5))
        pictures.append(stage.hdr(SIZE, CAMERA).copy())
    assert pictures[0][..., :3].max() > 0.5
    for other in pictures[1:]:
        np.testing.assert_allclose(other, pictures[0], atol=2e-3)


@pytest.mark.parametrize("name", [*LAYERS, "plain"])
@pytest.mark.parametrize("roughness", [0.0, 0.5])
def test_furnace_never_gains(stage: Stage, name: str, roughness: float) -> None:
    """In a uniform environment no white surface sends out more than it receives."""
    values = LAYERS.get(name, {}) | {"base_color": (1, 1, 1, 1), "roughness": roughness, "attenuation_distance": 0.0}
    values = {
        k: v for k, v in values.items() if name == "transmission" or not k.startswith(("attenuation", "thickness"))
    }
    stage.add(uv_sphere(), of("layered", *(() if name == "plain" else (name,)), **values))
    got = stage.hdr((48, 48), background="environment")[..., :3]
    assert got.max() < 1.006
    # a film keeps what it does not reflect, a coloured sheen takes its strongest channel from all of the base
    assert got.min() > {"plain": 0.998, "clearcoat": 0.99, "iridescence": 0.2, "sheen": 0.7}.get(name, 0.85)


def test_coat_adds_a_highlight_and_darkens_the_base(stage: Stage) -> None:
    seen = []
    for features in ((), ("clearcoat",)):
        stage.look(kind="none", sun_illuminance=1.0, sun_elevation=0.3, background="color", background_color=(0, 0, 0))
        stage.add(uv_sphere(), of("layered", *features, roughness=0.9, base_color=(0.5, 0.1, 0.1, 1)))
        seen.append(stage.hdr((64, 64))[..., :3].copy())
    assert seen[1].max() > 5 * seen[0].max()
    body = seen[0][..., 0] > 0.5 * np.median(seen[0][seen[0] > 0])
    assert np.median(seen[1][body][:, 0] / seen[0][body][:, 0]) < 0.99


def test_stretched_highlight(stage: Stage) -> None:
    """Along the tangent (here sideways) the highlight is wider than across."""
    mesh = card(1.0)
    extent = []
    for strength in (0.0, 0.9):
        stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0, 0, 0))
        stage.add(mesh, of("layered", "anisotropy", metallic=1.0, roughness=0.3, anisotropy=strength))
        stage.lamp(LightAsset("point", (1, 1, 1), 1.0), (0, 0, 1.0))
        picture = stage.hdr((64, 64), front_camera(0.5))[..., 0]
        lit = picture > 0.3 * picture.max()
        extent.append((lit.any(axis=0).sum(), lit.any(axis=1).sum()))
    assert abs(extent[0][0] - extent[0][1]) <= 2
    assert max(extent[1]) > 1.5 * min(extent[1])


def test_glass_shows_and_refracts_what_is_behind(stage: Stage) -> None:
    """A thin wall shifts nothing and tints; a body turns the picture behind it about."""
    stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0, 0, 0))
    stage.add(cube(0.5), surface(features=("unlit",), base_color=(1, 0, 0, 1)), (-0.5, 0, -1.0))
    stage.add(cube(0.5), surface(features=("unlit",), base_color=(0, 0, 1, 1)), (0.5, 0, -1.0))
    bare = stage.hdr((64, 64), front_camera(0.6)).copy()
    stage.add(card(4.0), of("layered", "transmission", roughness=0.0, base_color=(0.5, 0.5, 0.5, 1), specular=0.0))
    thin = stage.hdr((64, 64), front_camera(0.6)).copy()
    np.testing.assert_allclose(thin[..., :3], 0.5 * bare[..., :3], atol=0.05)
    stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0, 0, 0))
    stage.add(cube(0.5), surface(features=("unlit",), base_color=(1, 0, 0, 1)), (-0.5, 0, -1.0))
    stage.add(uv_sphere(0.5), of("layered", "transmission", roughness=0.0, thickness=1.0, ior=1.5))
    body = stage.hdr((64, 64), front_camera(0.6))
    red = np.argwhere(body[..., 0] > 0.3)
    assert len(red) > 0
    assert not np.allclose(body[..., :3], bare[..., :3], atol=0.1)


def test_rough_glass_blurs(stage: Stage) -> None:
    contrast = []
    for roughness in (0.0, 0.6):
        stage.look(kind="none", sun_illuminance=0.0, background="color", background_color=(0, 0, 0))
        stage.add(cube(0.5), surface(features=("unlit",), base_color=(1, 1, 1, 1)), (-0.25, 0, -1.0))
        stage.add(card(4.0), of("layered", "transmission", roughness=roughness, specular=0.0))
        picture = stage.hdr((64, 64), front_camera(0.6))[32, :, 0]
        contrast.append(np.abs(np.diff(picture)).max())
    assert contrast[0] > 3 * contrast[1]


def test_poison(stage: Stage) -> None:
    """Values at and beyond the ends of their ranges leave finite pictures."""
    for name, values in LAYERS.items():
        stage.look(kind="uniform", color=(0.2, 0.25, 0.3), sun_illuminance=0.7)
        odd = values | {"roughness": 0.0, "ior": 1.0, "specular": 0.0, "metallic": 1.0, "base_color": (0, 0, 0, 0)}
        node = stage.add(uv_sphere(0.5, 8, 16), of("layered", name, *(f for f in LAYERS if f != name), **odd))
        stage.lamp(LightAsset("point", (1, 1, 1), 1e6), (0.0, 0.0, 0.5))  # on the surface
        picture = stage.hdr((32, 32))
        assert np.isfinite(picture).all(), name
        assert node >= 0


def test_toon_has_few_shades(stage: Stage) -> None:
    stage.look(kind="none", sun_illuminance=3.0, sun_elevation=0.5, background="color", background_color=(0, 0, 0))
    stage.add(uv_sphere(), of("toon", softness=0.0, highlight=0.0, bands=3, base_color=(0.8, 0.8, 0.8, 1)))
    red = stage.hdr((64, 64))[..., 0]
    assert 3 <= len(np.unique(red.round(4))) <= 5


def test_null_device(null_device: Device) -> None:
    stage = Stage(null_device, kind="uniform", sun_illuminance=1.0)
    try:
        everything(stage)
        for path in PATHS:
            stage.runtime.renderer.render(stage.runtime.scene, stage.view(SIZE, CAMERA, path=path))
    finally:
        stage.close()
