"""Effect: what an effect file declares, checked and merged with what it extends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType

from engine.assets.mesh import STREAMS
from engine.core.errors import InputError, Place, UsageError
from engine.core.param import Param
from engine.core.toml_merge import Merged
from engine.core.toml_source import KeyPath
from engine.gpu.glsl_layout import BlockLayout
from engine.gpu.types import BlendState, SamplerDesc
from engine.materials import glsl
from engine.materials.requirements import LEVELS
from engine.materials.roles import PROCEDURAL, TARGETS
from engine.materials.suggest import hint
from engine.materials.technique import Technique, build

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


def texture_unit(index: int) -> int:
    """The unit of a slot by its place: the first ones below those of the renderer (8 to 31), the rest above."""
    return index if index < 8 else 24 + index


@dataclass(frozen=True, slots=True)
class TextureSlot:
    """A texture that a material may give. `space`: srgb | linear | normal; `default`: what an absent one shows.

    `sampler`: how it is sampled where the material says nothing else. `group`, `order`, `when`: as of a Param."""

    name: str
    unit: int
    space: str = "linear"
    default: str = "white"
    doc: str = ""
    sampler: SamplerDesc | None = None
    group: str = ""
    order: float = 0.0
    when: str = ""


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
    merged: Merged | None = None

    def place_of(self, keypath: KeyPath, message: str) -> tuple[str, Place]:
        """A message with the line and caret of a key's value in the file that says it, and its place."""
        if self.merged is None:
            return message, Place(str(self.files[0]))
        return self.merged.describe(keypath, message, value=True)

    @cached_property
    def findings(self) -> tuple[tuple[str, Place], ...]:
        """What is no mistake, but worth a word: (message, place). Roles that no pass asks for; roles of one level whose
        vertices are placed by other shaders, so that their depths differ."""
        found = []
        for role in self.techniques:
            if role not in TARGETS and role != PROCEDURAL:
                known = hint(role, TARGETS)
                text = f"no pass asks for the role {role!r} yet, so its technique is not drawn ({known})"
                found.append((text, ("technique", role)))
        forward = self.techniques.get("forward")
        for role in ("depth", "gbuffer", "shadow"):
            other = self.techniques.get(role)
            if forward is None or other is None:
                continue
            for level in LEVELS:
                mine, theirs = forward.at(level)[0], other.at(level)[0]
                if mine is None or theirs is None or mine.passes[0].shape == theirs.passes[0].shape:
                    continue
                text = f"at level {level}, {role} and forward place vertices by other stages: their depths may differ"
                found.append((text, ("technique", role)))
                break
        if self.merged is None:
            return tuple((text, Place(str(self.files[0]))) for text, _ in found)
        return tuple((text, self.merged.locate(keypath)[1]) for text, keypath in found)

    @cached_property
    def uses_stencil(self) -> bool:
        """Whether any pass of what is drawn on screen tests or writes the stencil."""
        drawn = (t for role, t in self.techniques.items() if role not in ("shadow", PROCEDURAL))
        return any(draw.stencil is not None for technique in drawn for draw in technique.every())

    @cached_property
    def computed(self) -> Mapping[str, str]:
        """The texture slots that the effect fills itself where a material gives no file, and their formats."""
        technique = self.techniques.get(PROCEDURAL)
        return technique.outputs if technique is not None else {}

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

    def computing_glsl(self) -> str:
        """Generated GLSL in front of the shaders of the technique that computes textures."""
        return glsl.generate_computing(self, self.computed)


def load_effect(path: Path, *, search: Sequence[Path] = ()) -> Effect:
    """Read an effect file; `extends` is looked for beside it and in `search`.

    Raises ShaderError with all mistakes (file:line:col, the line, a caret), InputError when a file cannot be read.
    """
    from engine.materials.merge import load_merged
    from engine.materials.schema import check  # pydantic is slow to import: only where an effect is read

    merged = load_merged(Path(path), search)
    model = check(merged)
    always = tuple(BUILTIN_FEATURES)
    return Effect(
        name=model.name,
        doc=model.doc,
        files=merged.files,
        source_hash=merged.source_hash,
        features={n: Feature(n, f.doc, f.implied_by, tuple(f.needs)) for n, f in model.features.items()},
        params=tuple(p.to_param(n) for n, p in model.params.items()),
        textures=tuple(
            TextureSlot(
                n,
                texture_unit(unit),
                s.space,
                s.default,
                s.doc,
                model.samplers[s.sampler].to_desc() if s.sampler else None,
                s.group,
                s.order,
                s.when,
            )
            for unit, (n, s) in enumerate(model.textures.items())
        ),
        techniques={role: build(role, technique, model, always) for role, technique in model.technique.items()},
        merged=merged,
    )
