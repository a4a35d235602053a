"""DrawState: what a batch of draws binds; how surfaces are ordered by it, and what of it a shadow map keeps."""

from __future__ import annotations

from dataclasses import dataclass, replace

from engine.materials.effect import Effect
from engine.materials.features import kept
from engine.resources.arena import MeshArena

#: queue -> order in the frame
QUEUE_ORDER = {"background": 0, "opaque": 1, "alpha_test": 2, "transparent": 3, "overlay": 4}


@dataclass(frozen=True, slots=True)
class DrawState:
    """What a batch binds. `blended` draws after everything opaque, back to front."""

    effect: str
    features: frozenset[str]
    arena: int
    group: int
    topology: str
    cull: str
    front_ccw: bool
    queue: str
    level: str = ""  # of techniques; '' as the view's quality says

    @property
    def blended(self) -> bool:
        return self.queue in ("transparent", "overlay") or self.transmissive

    @property
    def transmissive(self) -> bool:
        """It shows, refracted, what was drawn before it; so it is drawn with the blended ones, solid as it may be."""
        return "transmission" in self.features

    @property
    def veil(self) -> bool:
        """Its alpha counts: nearer and farther surfaces both stay to be seen."""
        return self.queue in ("transparent", "overlay")


@dataclass(frozen=True, slots=True)
class Batch:
    """Commands [first, first + count) drawn with one state."""

    state: DrawState
    first: int
    count: int


def casts_shadow(state: DrawState, effect: Effect) -> bool:
    """Solid, lit surfaces do. What is blended lets light through, what is unlit or a background is a picture of light,
    and an effect without a technique for the role cannot be drawn into a map."""
    return (
        state.queue in ("opaque", "alpha_test")
        and not state.transmissive
        and state.topology in ("triangles", "triangle_strip")
        and "unlit" not in state.features
        and "shadow" in effect.techniques
    )


def tints_light(state: DrawState, effect: Effect) -> bool:
    """Blended, lit surfaces do, which let a part of the light through; what lies over the picture is no part of it."""
    return (
        state.blended
        and state.queue != "overlay"
        and state.topology in ("triangles", "triangle_strip")
        and "unlit" not in state.features
        and "tint" in effect.techniques
    )


def caster_state(state: DrawState, effect: Effect) -> DrawState:
    """`state` without what makes no difference in a depth map. Both faces are drawn: an open shell casts as well."""
    features = effect.active("shadow", state.features)
    group = state.group
    if "alpha_test" not in features:
        painted = {name for name, f in effect.features.items() if f.implied_by or "color" in f.needs}
        features, group = frozenset(features - painted - {"uv1", "uv_transform"}), -1
    features = kept(features, state.features)
    return replace(state, features=features, group=group, cull="none", front_ccw=True, queue="opaque")


def sides_of(state: DrawState) -> tuple[DrawState, ...]:
    """The states in which a blended surface is drawn, in order."""
    if state.cull != "none":
        return (state,)
    return (replace(state, cull="front"), replace(state, cull="back"))


def sort_key(state: DrawState) -> tuple[object, ...]:
    return (
        state.effect, state.level, state.topology, state.cull, state.front_ccw, sorted(state.features), state.arena,
        state.group,
    )  # fmt: skip


def arena_streams(arena: MeshArena, effect: Effect, features: frozenset[str], role: str = "forward") -> tuple[str, ...]:
    """The streams that a variant with these features fetches: nothing that no one reads."""
    own = effect.techniques[role].streams if role in effect.techniques else ()
    depth_only = role in ("depth", "shadow", "tint")
    wanted = ["position"] if depth_only else ["position", "normal"]
    if "normal_map" in features and not depth_only:
        wanted.append("tangent")
    if "uv0" in arena.layout and any(f.implied_by for name, f in effect.features.items() if name in features):
        wanted.append("uv0")
    if "uv1" in features:
        wanted.append("uv1")
    if "vertex_color" in features:
        wanted.append("color")
    if "skinning" in features:
        wanted += ["joints", "weights", "joints1", "weights1"]
    wanted += [name for name in own if name not in wanted]
    return tuple(name for name in wanted if name in arena.layout)
