"""Which features a material on a mesh switches on, and why. The reasons feed --explain."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from engine.assets.material import MaterialAsset, TextureRef
from engine.core.errors import InputError
from engine.materials.effect import Effect
from engine.materials.suggest import hint


class FeatureSet(frozenset[str]):
    """A frozenset of feature names (equal to a plain one) that remembers why.

    `reasons`: feature -> why it is on. `dropped`: feature -> why it is off although it was wanted.
    """

    reasons: Mapping[str, str]
    dropped: Mapping[str, str]

    def __new__(
        cls, reasons: Mapping[str, str] | Iterable[str] = (), dropped: Mapping[str, str] | None = None
    ) -> FeatureSet:
        self = super().__new__(cls, reasons)
        self.reasons = dict(reasons) if isinstance(reasons, Mapping) else {}
        self.dropped = dict(dropped or {})
        return self


def kept(features: Iterable[str], of: frozenset[str]) -> FeatureSet:
    """Some of the features of a set, with the reasons that it knows."""
    told = of if isinstance(of, FeatureSet) else FeatureSet()
    return FeatureSet({name: told.reasons.get(name, "asked for") for name in features}, told.dropped)


def resolve_features(
    effect: Effect, material: MaterialAsset, mesh_layout: Sequence[str], also: Mapping[str, str] | None = None
) -> FeatureSet:
    """The features of the variant that draws `material` on a mesh with the streams `mesh_layout`.

    On are: what the material asks for; what its textures, and those that the effect computes, imply; `vertex_color`
    when the mesh has colours; `alpha_test` in the queue of that name; `uv1` and `uv_transform` when a used texture
    needs them. A feature whose vertex streams the mesh lacks is dropped. `also`: feature -> reason, taken where the
    effect has it.
    Raises InputError with did-you-mean for features and textures that the effect has not.
    """
    _check_names(effect, material)
    wanted = dict.fromkeys(material.features, "the material asks for it")
    for name, feature in effect.features.items():
        if feature.implied_by in material.textures:
            wanted.setdefault(name, f"the material has the texture {feature.implied_by!r}")
        elif feature.implied_by in effect.computed:
            wanted.setdefault(name, f"the effect computes the texture {feature.implied_by!r}")
    if "vertex_color" in effect.features and "color" in mesh_layout:
        wanted.setdefault("vertex_color", "the mesh has vertex colours")
    if "alpha_test" in effect.features and material.queue == "alpha_test":
        wanted.setdefault("alpha_test", "the material's queue is alpha_test")
    for name, reason in (also or {}).items():
        if name in effect.features:
            wanted.setdefault(name, reason)
    dropped: dict[str, str] = {}
    for name in list(wanted):
        missing = [s for s in effect.features[name].needs if s not in mesh_layout] if name in effect.features else []
        if missing:
            dropped[name] = f"{wanted.pop(name)}, but the mesh has no {' and no '.join(missing)}"
    used = _used_textures(effect, material, wanted.keys())
    second = [slot for slot, ref in used.items() if ref.uv_set == 1]
    if second and "uv1" in mesh_layout:
        wanted["uv1"] = f"{', '.join(second)} read the second uv set"
    elif second:
        dropped["uv1"] = f"{', '.join(second)} want the second uv set, but the mesh has no uv1"
        wanted.pop("uv1", None)
    moved = [slot for slot, ref in used.items() if not is_identity(ref)]
    if moved:
        wanted["uv_transform"] = f"the uv of {', '.join(moved)} are transformed"
    return FeatureSet(wanted, dropped)


def is_identity(ref: TextureRef) -> bool:
    """Whether the texture's uv stay as they are."""
    return tuple(ref.offset) == (0.0, 0.0) and ref.rotation == 0.0 and tuple(ref.scale) == (1.0, 1.0)


def _used_textures(effect: Effect, material: MaterialAsset, features: Iterable[str]) -> dict[str, TextureRef]:
    """Textures that this variant can sample: all but those whose features are all off."""
    on = set(features)
    implying: dict[str, list[str]] = {}
    for name, feature in effect.features.items():
        if feature.implied_by:
            implying.setdefault(feature.implied_by, []).append(name)
    return {
        slot: ref for slot, ref in material.textures.items() if slot not in implying or on.intersection(implying[slot])
    }


def _check_names(effect: Effect, material: MaterialAsset) -> None:
    mistakes = [
        f"unknown {kind} {name!r} ({hint(name, known)})"
        for kind, names, known in (
            ("feature", material.features, effect.features), ("texture", material.textures, effect.slot_by_name),
        )
        for name in names
        if name not in known
    ]  # fmt: skip
    if mistakes:
        raise InputError(f"material {material.name!r} of effect {effect.name!r}: {'; '.join(mistakes)}")
