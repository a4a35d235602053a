"""Effect: what an effect file declares, checked and merged with what it extends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

from engine.assets.mesh import STREAMS
from engine.core.errors import InputError, UsageError
from engine.core.param import Param
from engine.gpu.glsl_layout import BlockLayout
from engine.gpu.types import BlendState, DepthState, RasterState
from engine.materials import glsl
from engine.materials.suggest import hint

LEVELS = ("low", "medium", "high")

#: blend names of effect files; None writes as it is
BLENDS: Mapping[str, BlendState | None] = MappingProxyType(
    {
        "opaque": None,
        "alpha": BlendState("src_alpha", "one_minus_src_alpha", "add", "one", "one_minus_src_alpha", "add"),
        "premultiplied": BlendState("one", "one_minus_src_alpha", "add", "one", "one_minus_src_alpha", "add"),
        "additive": BlendState("one", "one", "add", "one", "one", "add"),
        "multiply": BlendState("dst_color", "zero", "add", "zero", "one", "add"),
    }
)

#: features that every effect has, since the generated sample_<slot>() functions depend on them
BUILTIN_FEATURES: Mapping[str, str] = MappingProxyType(
    {
        "uv1": "a texture reads the second uv set",
        "uv_transform": "a texture's uv are scaled, turned or moved",
    }
)


@dataclass(frozen=True, slots=True)
class Feature:
    """A switch of the shader. `implied_by`: the texture slot that switches it on; `needs`: vertex streams."""

    name: str
    doc: str = ""
    implied_by: str = ""
    needs: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TextureSlot:
    """A texture that a material may give. `space`: srgb | linear | normal; `default`: what an absent one shows."""

    name: str
    unit: int
    space: str = "linear"
    default: str = "white"
    doc: str = ""


@dataclass(frozen=True, slots=True)
class Technique:
    """How the effect is drawn in a role (forward, depth, gbuffer, shadow …). `fragment` '' draws depth only.

    `features`: those that make a difference in this role (None: all); others are off, so variants are shared.
    """

    role: str
    vertex: str
    fragment: str = ""
    level: str = "low"
    depth: DepthState = field(default_factory=DepthState)
    raster: RasterState = field(default_factory=RasterState)
    blend: str = "opaque"
    features: frozenset[str] | None = None


@dataclass(frozen=True, eq=False)
class Effect:
    """A loaded effect. Mappings are in declaration order, those of `extends` first. Compared by identity.

    `files`: the effect file and what it extends. `source_hash`: of their bytes.
    """

    name: str
    doc: str
    files: tuple[Path, ...]
    source_hash: str
    features: Mapping[str, Feature]
    params: tuple[Param, ...]
    textures: tuple[TextureSlot, ...]
    techniques: Mapping[str, Technique]

    @cached_property
    def param_by_name(self) -> Mapping[str, Param]:
        return {param.name: param for param in self.params}

    @cached_property
    def slot_by_name(self) -> Mapping[str, TextureSlot]:
        return {slot.name: slot for slot in self.textures}

    @cached_property
    def row_layout(self) -> BlockLayout:
        """std430 layout of one MaterialParams: the params, then `<slot>_layer/_uv/_row0/_row1` of each texture slot."""
        return glsl.row_layout(self)

    def param(self, name: str) -> Param:
        """Raises UsageError with did-you-mean for an unknown name."""
        if name not in self.param_by_name:
            raise UsageError(f"effect {self.name!r} has no parameter {name!r}", hint=hint(name, self.param_by_name))
        return self.param_by_name[name]

    def technique(self, role: str) -> Technique:
        """Raises InputError with did-you-mean when the effect does not draw in that role."""
        if role not in self.techniques:
            raise InputError(
                f"effect {self.name!r} has no technique for the role {role!r}",
                where=self.files[0], hint=hint(role, self.techniques),
            )  # fmt: skip
        return self.techniques[role]

    def check_features(self, features: frozenset[str]) -> None:
        """Raises InputError with did-you-mean when the effect has not all of them."""
        known = {*self.features, *BUILTIN_FEATURES}
        unknown = sorted(features - known)
        if unknown:
            raise InputError(
                f"effect {self.name!r} has no feature {', '.join(map(repr, unknown))}",
                where=self.files[0], hint=hint(unknown[0], known),
            )  # fmt: skip

    def active(self, role: str, features: frozenset[str]) -> frozenset[str]:
        """Those of `features` that make a difference in `role`. Raises InputError for unknown features or roles."""
        technique = self.technique(role)
        self.check_features(features)
        return frozenset(features if technique.features is None else features & technique.features)

    def defines(self, role: str, features: frozenset[str], streams: Sequence[str] = ()) -> dict[str, int]:
        """Macros of a variant, all of them always there: features, ROLE_<ROLE>, HAS_<STREAM>; 0 or 1."""
        macros = {name.upper(): int(name in features) for name in (*BUILTIN_FEATURES, *self.features)}
        macros |= {f"ROLE_{name.upper()}": int(name == role) for name in self.techniques}
        return macros | {f"HAS_{name.upper()}": int(name in streams) for name in STREAMS}

    def glsl(self, features: frozenset[str]) -> str:
        """Generated GLSL of a variant: MaterialParams, the buffer of materials, samplers, sample_<slot>()."""
        return glsl.generate(self, features)


def load_effect(path: Path, *, search: Sequence[Path] = ()) -> Effect:
    """Read an effect file; `extends` is looked for beside it and in `search`.

    Raises ShaderError with all mistakes (file:line:col, the line, a caret), InputError when a file cannot be read.
    """
    from engine.materials.merge import load_merged
    from engine.materials.schema import check  # pydantic is slow to import: only where an effect is read

    merged = load_merged(Path(path), search)
    model = check(merged)
    techniques = {}
    for role, t in model.technique.items():
        techniques[role] = Technique(
            role, t.vertex, t.fragment, t.level,
            DepthState(t.depth.test, t.depth.write, t.depth.compare, t.depth.bias, t.depth.bias_slope),
            RasterState(t.raster.cull, True, t.raster.fill, t.raster.depth_clamp),
            t.blend, None if t.features is None else frozenset((*t.features, *BUILTIN_FEATURES)),
        )  # fmt: skip
    return Effect(
        name=model.name,
        doc=model.doc,
        files=merged.files,
        source_hash=merged.source_hash,
        features={n: Feature(n, f.doc, f.implied_by, tuple(f.needs)) for n, f in model.features.items()},
        params=tuple(p.to_param(n) for n, p in model.params.items()),
        textures=tuple(
            TextureSlot(n, unit, s.space, s.default, s.doc) for unit, (n, s) in enumerate(model.textures.items())
        ),
        techniques=techniques,
    )
