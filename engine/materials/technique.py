"""Technique: how an effect is drawn in one role: levels, passes, stages, state, all that they inherit filled in.

    states (named groups) < technique < states of the level < level < states of the pass < pass      later ones win

Every pass is a draw of the whole batch, in order; of the role `texture`, a dispatch over all texels. A stage given as
"" is taken away.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from engine.core.toml_source import KeyPath
from engine.gpu.types import BlendState, Caps, DepthState, RasterState, StencilState
from engine.materials.requirements import AUTO, choose
from engine.materials.roles import target_index

if TYPE_CHECKING:
    from engine.materials.schema import EffectModel, LevelModel, PassModel, TechniqueModel

STAGES = ("vertex", "tess_control", "tess_evaluation", "geometry", "fragment", "compute")


@dataclass(frozen=True, slots=True)
class TargetState:
    """What a technique says of one colour target; None: as of all."""

    blend: str | BlendState | None = None
    write_mask: str | None = None


@dataclass(frozen=True, slots=True)
class DrawPass:
    """One draw. A stage '' is not there: without `fragment` depth alone is drawn. `blend`: a word of BLENDS or a state.

    `targets`: by the number of the target. `places`: stage -> the key that named its file."""

    name: str = ""
    vertex: str = ""
    tess_control: str = ""
    tess_evaluation: str = ""
    geometry: str = ""
    fragment: str = ""
    compute: str = ""
    patch_vertices: int = 3
    defines: Mapping[str, str | int] = field(default_factory=dict, hash=False)
    depth: DepthState = field(default_factory=DepthState)
    stencil: StencilState | None = None
    raster: RasterState = field(default_factory=RasterState)
    blend: str | BlendState = "opaque"
    blend_constant: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    write_mask: str = "rgba"
    targets: Mapping[int, TargetState] = field(default_factory=dict, hash=False)
    places: Mapping[str, KeyPath] = field(default_factory=dict, hash=False, compare=False)

    def stages(self) -> dict[str, str]:
        """stage -> file, of those that there are, in the order of the pipeline."""
        return {stage: getattr(self, stage) for stage in STAGES if getattr(self, stage)}

    @property
    def shape(self) -> tuple[str, ...]:
        """The stages that decide where its fragments lie."""
        return self.vertex, self.tess_control, self.tess_evaluation, self.geometry

    def target(self, index: int) -> TargetState:
        own = self.targets.get(index, TargetState())
        return TargetState(
            self.blend if own.blend is None else own.blend,
            self.write_mask if own.write_mask is None else own.write_mask,
        )


@dataclass(frozen=True, slots=True)
class Technique:
    """How the effect is drawn in a role, at one level. `features`: those that make a difference in this role (None:
    all); others are off, so variants are shared. `streams`: of the mesh, that it reads in any case. `levels`: all that
    there are, this one too. `size`, `outputs`: of what is computed, texels and texture slot -> format."""

    role: str
    passes: tuple[DrawPass, ...]
    level: str = "low"
    requires: tuple[str, ...] = ()
    features: frozenset[str] | None = None
    streams: tuple[str, ...] = ()
    size: tuple[int, int] = (0, 0)
    outputs: Mapping[str, str] = field(default_factory=dict, hash=False)
    levels: Mapping[str, Technique] = field(default_factory=dict, hash=False, compare=False)

    def at(self, wanted: str = AUTO, caps: Caps | None = None) -> tuple[Technique | None, str]:
        """The level to be drawn on a device, and why. None: the device can do none of them."""
        level, why = choose({name: t.requires for name, t in self.levels.items()}, wanted, caps)
        return (self.levels[level] if level else None), why

    def every(self) -> Iterator[DrawPass]:
        """The passes of all levels."""
        for technique in self.levels.values():
            yield from technique.passes

    @property
    def files(self) -> set[str]:
        """All shader files of all levels."""
        return {file for draw in self.every() for file in draw.stages().values()}

    # those of the first pass, which is the only one of most techniques

    @property
    def vertex(self) -> str:
        return self.passes[0].vertex

    @property
    def fragment(self) -> str:
        return self.passes[0].fragment

    @property
    def depth(self) -> DepthState:
        return self.passes[0].depth

    @property
    def raster(self) -> RasterState:
        return self.passes[0].raster

    @property
    def blend(self) -> str | BlendState:
        return self.passes[0].blend


def build(role: str, model: TechniqueModel, effect: EffectModel, always: tuple[str, ...]) -> Technique:
    """The technique of a checked model. `always`: features that every role has."""
    at: KeyPath = ("technique", role)
    features = None if model.features is None else frozenset((*model.features, *always))
    techniques: dict[str, Technique] = {model.level: _level(role, model.level, effect, [(at, model)], model, features)}
    for name, level in model.levels.items():
        layers: list[tuple[KeyPath, PassModel]] = [(at, model), ((*at, "levels", name), level)]
        techniques[name] = _level(role, name, effect, layers, level, features)
    levels = MappingProxyType(dict(techniques))
    streams, outputs = tuple(model.streams), MappingProxyType(dict(model.outputs))
    made: dict[str, Technique] = {
        name: replace(technique, levels=levels, streams=streams, outputs=outputs)
        for name, technique in techniques.items()
    }
    return replace(made[model.level], levels=MappingProxyType(made))


def _level(
    role: str, name: str, effect: EffectModel, layers: list[tuple[KeyPath, PassModel]], own: LevelModel,
    features: frozenset[str] | None,
) -> Technique:  # fmt: skip
    base: LevelModel = layers[0][1]  # type: ignore[assignment]  # a technique is the first layer, and is a level
    last, passes = layers[-1][0], own.passes
    if not passes:
        last, passes = layers[0][0], base.passes
    drawn = [_draw(role, effect, [*layers, ((*last, "passes", i), p)]) for i, p in enumerate(passes)]
    width, height = own.size or base.size or (0, 0)  # texels
    return Technique(
        role, tuple(drawn) or (_draw(role, effect, layers),), name, tuple(own.requires), features, size=(width, height)
    )


def _draw(role: str, effect: EffectModel, layers: list[tuple[KeyPath, PassModel]]) -> DrawPass:
    from engine.materials import state_schema as state

    said: dict[str, Any] = {}
    places: dict[str, KeyPath] = {}
    defines: dict[str, str | int] = {}
    groups: list[state.Table] = []
    for at, layer in layers:
        groups += [effect.states[group] for group in layer.states if group in effect.states]
        groups.append(layer)
        for name in (*STAGES, "patch_vertices"):
            if name in layer.model_fields_set:
                said[name], places[name] = getattr(layer, name), (*at, name)
        defines |= {name: repr(v) if isinstance(v, float) else int(v) for name, v in layer.defines.items()}
    all_of = state.combined(groups)
    constant = all_of.blend_constant
    targets = {
        index: TargetState(None if t.blend is None else state.blend_state(t.blend), t.write_mask)
        for name, t in all_of.targets.items()
        if (index := target_index(role, name)) is not None
    }
    return DrawPass(
        **said, name=getattr(layers[-1][1], "name", ""), defines=MappingProxyType(defines),
        depth=state.depth_state(all_of.depth), stencil=state.stencil_state(all_of),
        raster=state.raster_state(all_of.raster), blend=state.blend_state(all_of.blend),
        blend_constant=(constant[0], constant[1], constant[2], constant[3]), write_mask=all_of.write_mask,
        targets=MappingProxyType(targets), places=MappingProxyType(places),
    )  # fmt: skip
