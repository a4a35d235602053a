"""The order in which parameters and texture slots stand in a panel, and which show at all. No imgui."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeVar


class Grouped(Protocol):
    """What a Param and a TextureSlot declare of their place; all of it may be left out."""

    @property
    def name(self) -> str: ...


G = TypeVar("G", bound=Grouped)


def facts_of(effect: Any, asset: Any, values: Mapping[str, Any]) -> dict[str, Any]:
    """What conditions ask about: values of parameters; True or False for features and textures of a material."""
    slots = {slot.name: slot.name in asset.textures for slot in effect.textures}
    implied = {name: slots.get(f.implied_by, False) for name, f in getattr(effect, "features", {}).items()}
    return {**slots, **{name: on or name in asset.features for name, on in implied.items()}, **values}


def grouped(items: Sequence[G], facts: Mapping[str, Any]) -> dict[str, list[G]]:
    """group -> its items by their order, then as declared, of those whose condition holds. '' comes first, the others
    as they first occur."""
    groups: dict[str, list[G]] = {"": []}
    for item in sorted(items, key=lambda i: float(getattr(i, "order", 0.0))):
        if shows(item, facts):
            groups.setdefault(getattr(item, "group", ""), []).append(item)
    return {name: members for name, members in groups.items() if members}


def shows(item: Grouped, facts: Mapping[str, Any]) -> bool:
    """Whether the parameter or slot means something under these facts."""
    from engine.materials.condition import condition_of

    when = getattr(item, "when", "")
    return not when or condition_of(when).holds(facts)
