"""Roles: what a pass of the renderer asks an effect's technique for, and what stands in where the effect has none.

An effect may have techniques for other roles, which passes added later ask for; until then they are said to be unused.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

#: role -> names of its colour targets, by their number; a depth target has none
TARGETS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "forward": ("color",),
        "gbuffer": ("color", "gbuffer0", "gbuffer1", "gbuffer2"),
        "depth": (),
        "shadow": (),
        "tint": ("tint",),
        "layer": ("shape", "light"),
        "motion": ("motion",),
    }
)

#: the role of a technique that draws nothing: it computes textures of the effect (engine.resources.procedural)
PROCEDURAL = "texture"

#: role -> what happens to a surface whose effect has no technique for it
ABSENT: Mapping[str, str] = MappingProxyType(
    {
        "forward": "is not drawn where nothing is deferred",
        "gbuffer": "is drawn by its technique for forward, behind the lighting",
        "depth": "is not in the depth that is drawn first; all local lights are looked at for it",
        "shadow": "casts no shadow",
        "tint": "lets the sun through as if it were not there, where shadows are translucent",
        "layer": "sends no light to other surfaces, and reflections do not show it",
        "motion": "is taken for standing still by what is gathered over frames",
    }
)

MOST_TARGETS = 8


def target_index(role: str, name: str) -> int | None:
    """The number of a colour target given by name or number; None where the role has no such target."""
    names = TARGETS.get(role, ())
    if name in names:
        return names.index(name)
    if name.isdigit() and int(name) < (len(names) if role in TARGETS else MOST_TARGETS):
        return int(name)
    return None
