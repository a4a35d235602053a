"""Which sampler a texture slot gets: the effect's group, then what the material says, then the view's setting."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.assets.material import MaterialAsset, TextureRef
from engine.core.paths import shaders_dir
from engine.gpu.types import Device, SamplerDesc
from engine.materials.library import EffectLibrary
from engine.resources.residency import Residency

EFFECT = """name = "x"
[samplers.soft]
wrap = "border"
border = "white"
lod_max = 3.0
[samplers.sharp]
anisotropy = 4.0
[textures.a_map]
sampler = "soft"
[textures.b_map]
sampler = "sharp"
[textures.c_map]
[technique.forward]
vertex = "effects/surface.vert"
"""
WHITE = (1.0, 1.0, 1.0, 1.0)


@pytest.fixture
def residency(null_device: Device, tmp_path: Path) -> Residency:
    (tmp_path / "x.effect.toml").write_text(EFFECT, encoding="utf-8")
    return Residency(null_device, EffectLibrary([tmp_path, shaders_dir()]))


def samplers(residency: Residency, anisotropy: float, **textures: TextureRef) -> list[SamplerDesc]:
    material = residency.add_material(MaterialAsset("m", "x", textures=dict(textures)), Path())
    bound = residency.materials.bindings(residency.material(material).group, anisotropy)
    return [bound[unit][1].desc for unit in range(3)]


def test_the_group_then_the_material_then_the_view(residency: Residency) -> None:
    soft, sharp, plain = samplers(residency, 8.0)
    assert soft == SamplerDesc("border", "border", "border", anisotropy=8.0, border=WHITE, lod_max=3.0)
    assert sharp == SamplerDesc(anisotropy=4.0), "by hand in the group: the view's setting does not count"
    assert plain == SamplerDesc(anisotropy=8.0)
    own = samplers(residency, 1.0, a_map=TextureRef("", wrap_u="mirror"), c_map=TextureRef("", min_filter="linear"))
    assert (own[0].wrap_u, own[0].wrap_v, own[0].anisotropy) == ("mirror", "border", 1.0)
    assert (own[2].min_filter, own[2].anisotropy) == ("linear", 1.0)


def test_a_default_that_is_meant_goes_over_the_group(residency: Residency) -> None:
    plain = samplers(residency, 1.0, a_map=TextureRef("", wrap_u="repeat"))[0]
    meant = samplers(residency, 1.0, a_map=TextureRef("", wrap_u="repeat", stated=("wrap_u",)))[0]
    assert (plain.wrap_u, meant.wrap_u, meant.wrap_v) == ("border", "repeat", "border")
