"""EffectLibrary: effects by name, their variants as pipelines, hot reload that never loses the last good one."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from engine.core.errors import InputError, LucarnaError, ShaderError
from engine.gpu.types import Device, Pipeline, VertexAttribute
from engine.materials.effect import Effect, load_effect
from engine.materials.features import FeatureSet
from engine.materials.merge import SUFFIX, candidates
from engine.materials.suggest import hint
from engine.materials.variant import (
    MAGENTA,
    Compiled,
    StateOptions,
    Variant,
    VariantRequest,
    absent_features,
    compile_nowhere,
    compile_variant,
    let_go,
    shader_file,
)

#: of a watched file: (mtime in ns, size), None when it is not there
Stamp = tuple[int, int] | None


class EffectLibrary:
    """`search`: folders with shaders (`effects/x.effect.toml`, `lib/y.glsl`); the first that has a file counts.

    `compiled` counts compilations. `errors`: effect name -> why its newest files are not in use.
    """

    def __init__(self, search: Sequence[Path], *, prelude: str = "") -> None:
        self.search = tuple(Path(folder) for folder in search)
        self.prelude = prelude
        self.compiled = 0
        self.errors: dict[str, LucarnaError] = {}
        self._effects: dict[str, Effect] = {}
        self._variants: dict[tuple[int, VariantRequest], Variant] = {}
        self._stamps: dict[Path, Stamp] = {}

    # --- effects ---

    def names(self) -> list[str]:
        """The names of all effects in the search folders."""
        return sorted(candidates(self.search))

    def get(self, name: str) -> Effect:
        """The effect, loaded once. Raises InputError (did you mean) for an unknown one, ShaderError for a bad one."""
        effect = self._effects.get(name)
        if effect is None:
            effect = self._effects[name] = self._load(name)
            self._watch(effect.files)
        return effect

    def _load(self, name: str) -> Effect:
        files = candidates(self.search)
        if name not in files:
            folders = ", ".join(map(str, self.search))
            raise InputError(f"there is no effect {name!r} ({name}{SUFFIX}) in {folders}", hint=hint(name, files))
        return load_effect(files[name], search=self.search)

    # --- variants ---

    def pipeline(
        self, device: Device, effect: Effect | str, role: str, features: frozenset[str] = frozenset(),
        attributes: tuple[VertexAttribute, ...] = (), *, defines: Mapping[str, str | int] | None = None,
        prelude: str = "", **state: Unpack[StateOptions],
    ) -> Pipeline:  # fmt: skip
        """The pipeline of a variant, compiled once; one dict look-up when it is there.

        `state`: what is left out is as the technique says (see StateOptions). `defines` go over the generated ones.
        `prelude` (GLSL, after the library's) stands before the effect's generated text in both stages.
        Raises ShaderError when it does not compile, InputError for a role or feature that the effect has not.
        """
        name = effect if isinstance(effect, str) else effect.name
        request = VariantRequest(name, role, features, attributes, defines=_items(defines), prelude=prelude, **state)
        variant = self._variant(device, effect, request)
        if variant.pipeline is None:
            assert variant.error is not None
            raise variant.error
        return variant.pipeline

    def pipeline_or_magenta(
        self, device: Device, effect: Effect | str, role: str, features: frozenset[str] = frozenset(),
        attributes: tuple[VertexAttribute, ...] = (), *, defines: Mapping[str, str | int] | None = None,
        prelude: str = "", **state: Unpack[StateOptions],
    ) -> tuple[Pipeline, ShaderError | None]:  # fmt: skip
        """As `pipeline`, but what does not compile is drawn in magenta (nothing, if its vertex shader is bad too).

        The error is that of the newest source, also where the last good pipeline is still drawn.
        """
        name = effect if isinstance(effect, str) else effect.name
        request = VariantRequest(name, role, features, attributes, defines=_items(defines), prelude=prelude, **state)
        variant = self._variant(device, effect, request)
        if variant.pipeline is not None:
            return variant.pipeline, variant.error
        if variant.fallback is None:
            variant.fallback = self._magenta(variant)
        return variant.fallback, variant.error

    def variants(self) -> list[Variant]:
        """All variants asked for so far, in that order."""
        return list(self._variants.values())

    def _variant(self, device: Device, effect: Effect | str, request: VariantRequest) -> Variant:
        key = (id(device), request)
        variant = self._variants.get(key)
        if variant is None:
            if isinstance(effect, Effect):
                current = self._effects.setdefault(effect.name, effect)
                self._watch(current.files)
            else:
                current = self.get(effect)
            variant = self._variants[key] = self._new(device, current, request)
        return variant

    def _new(self, device: Device, effect: Effect, request: VariantRequest) -> Variant:
        active = effect.active(request.role, request.features)
        told = request.features if isinstance(request.features, FeatureSet) else FeatureSet()
        variant = Variant(
            request, device, active,
            {name: told.reasons.get(name, "asked for") for name in active},
            absent_features(effect, request.role, request.features, told.dropped),
        )  # fmt: skip
        outcome = self._compile(device, effect, request)
        self._adopt(variant, outcome)
        return variant

    def _compile(self, device: Device, effect: Effect, request: VariantRequest) -> Compiled | ShaderError:
        technique = effect.technique(request.role)
        wanted = [technique.vertex, technique.fragment] if technique.fragment else [technique.vertex]
        self._watch(shader_file(name, self.search) for name in wanted)
        self.compiled += 1
        try:
            result = compile_variant(device, effect, self._with_prelude(request), self.search)
        except ShaderError as error:
            self._watch(self._folders())
            return error
        self._watch(result.files)
        return result

    def _magenta(self, variant: Variant) -> Pipeline:
        effect = self._effects[variant.request.effect]
        self.compiled += 1
        try:
            request = self._with_prelude(variant.request)
            return compile_variant(variant.device, effect, request, self.search, magenta=True).pipeline
        except ShaderError:
            return compile_nowhere(variant.device, variant.request)

    def _with_prelude(self, request: VariantRequest) -> VariantRequest:
        return replace(request, prelude=self.prelude + request.prelude) if self.prelude else request

    def _adopt(self, variant: Variant, outcome: Compiled | ShaderError) -> None:
        if isinstance(outcome, ShaderError):
            variant.error = outcome
            return
        let_go(variant)
        variant.pipeline, variant.files, variant.source_hash = outcome.pipeline, outcome.files, outcome.source_hash

    def release(self) -> None:
        """Let all pipelines go."""
        for variant in self._variants.values():
            let_go(variant)
        self._variants.clear()

    # --- hot reload ---

    def poll(self) -> list[str]:
        """Look whether files changed (mtime and size); compile aside, and return the effects that now are new ones.

        All variants of an effect change together, or none: when one that was good does not compile any more, or the
        effect file is wrong, the effect stays as it was and `errors` says why. After a change, ask for pipelines again,
        and (if `get` gives another Effect) move the tables with `MaterialTable.migrate`.
        """
        changed = {path for path, stamp in self._stamps.items() if _stamp(path) != stamp}
        if not changed:
            return []
        for path in changed:
            self._stamps[path] = _stamp(path)
        return [name for name in list(self._effects) if changed & self._files(name) and self._reload(name)]

    def _files(self, name: str) -> set[Path]:
        effect = self._effects[name]
        files = set(effect.files)
        for technique in effect.techniques.values():
            files |= {shader_file(file, self.search) for file in (technique.vertex, technique.fragment) if file}
        for variant in self._of(name):
            files |= set(variant.files)
            files |= {Path(variant.error.where.file)} if variant.error is not None else set()
        if any(variant.fallback is not None for variant in self._of(name)):
            files.add(shader_file(MAGENTA, self.search))
        if name in self.errors or any(variant.error is not None for variant in self._of(name)):
            files |= self._folders()  # what is missing may come
        return files

    def _folders(self) -> set[Path]:
        """The search folders and the folders in them."""
        inner = {path for folder in self.search if folder.is_dir() for path in folder.iterdir() if path.is_dir()}
        return inner.union(self.search)

    def _of(self, name: str) -> list[Variant]:
        return [variant for variant in self._variants.values() if variant.request.effect == name]

    def _reload(self, name: str) -> bool:
        old = self._effects[name]
        try:
            effect = load_effect(old.files[0], search=self.search)
        except LucarnaError as error:
            self.errors[name] = error
            return False
        self._watch(effect.files)
        if effect.source_hash == old.source_hash:
            effect = old
        outcomes: list[tuple[Variant, Compiled | ShaderError]] = []
        gone: list[Variant] = []
        for variant in self._of(name):
            try:
                effect.active(variant.request.role, variant.request.features)
            except InputError:
                gone.append(variant)
                continue
            outcomes.append((variant, self._compile(variant.device, effect, variant.request)))
        bad = [(variant, out) for variant, out in outcomes if isinstance(out, ShaderError)]
        worse = [error for variant, error in bad if variant.pipeline is not None]
        if bad:
            self.errors[name] = (worse or [bad[0][1]])[0]
        else:
            self.errors.pop(name, None)
        for variant, outcome in outcomes:
            if not worse or isinstance(outcome, ShaderError):
                self._adopt(variant, outcome)
            else:
                outcome.pipeline.release()
        if worse:
            return False
        self._effects[name] = effect
        for variant in gone:
            let_go(variant)
        self._variants = {key: variant for key, variant in self._variants.items() if variant not in gone}
        return True

    def _watch(self, files: Iterable[Path]) -> None:
        for path in files:
            if path not in self._stamps:
                self._stamps[path] = _stamp(path)


def _items(defines: Mapping[str, str | int] | None) -> tuple[tuple[str, str | int], ...]:
    return tuple(sorted(defines.items())) if defines else ()


def _stamp(path: Path) -> Stamp:
    try:
        info = path.stat()
    except OSError:
        return None
    return info.st_mtime_ns, info.st_size
