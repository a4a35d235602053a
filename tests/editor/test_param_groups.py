"""Where parameters stand and when they show."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

from editor.param_groups import facts_of, grouped
from engine.assets.material import MaterialAsset, TextureRef
from engine.core.param import Param

BASE = Param("a", "float", 0.0)


def names(groups: dict[str, list[Param]]) -> dict[str, list[str]]:
    return {group: [p.name for p in members] for group, members in groups.items()}


def test_by_group_then_order_then_as_declared() -> None:
    params = [
        BASE,
        replace(BASE, name="wet", group="Weather"),
        replace(BASE, name="first", order=-1.0),
        replace(BASE, name="moss", group="Moss"),
        replace(BASE, name="dry", group="Weather", order=-2.0),
        replace(BASE, name="b"),
    ]
    assert names(grouped(params, {})) == {"": ["first", "a", "b"], "Weather": ["dry", "wet"], "Moss": ["moss"]}


def test_what_does_not_matter_is_left_out_with_its_group() -> None:
    params = [BASE, replace(BASE, name="wet", group="Weather", when="a > 0.5 and normal_map")]
    assert names(grouped(params, {"a": 1.0, "normal_map": False})) == {"": ["a"]}
    assert names(grouped(params, {"a": 1.0, "normal_map": True})) == {"": ["a"], "Weather": ["wet"]}


def test_conditions_know_textures_and_features() -> None:
    effect = SimpleNamespace(
        textures=[SimpleNamespace(name="moss_map"), SimpleNamespace(name="rock_map")],
        features={
            "moss": SimpleNamespace(implied_by="moss_map"),
            "rock": SimpleNamespace(implied_by="rock_map"),
            "unlit": SimpleNamespace(implied_by=""),
        },
    )
    asset = MaterialAsset("m", features=["unlit"], textures={"moss_map": TextureRef("moss.dds")})
    facts = facts_of(effect, asset, {"wetness": 0.3})
    assert facts == {"moss_map": True, "rock_map": False, "moss": True, "rock": False, "unlit": True, "wetness": 0.3}
