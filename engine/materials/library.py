"""EffectLibrary: effects by name, their variants as pipelines, hot reload that never loses the last good one."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Unpack

from engine.core.errors import InputError, LucarnaError, ShaderError
from engine.core.watched import Watched
from engine.gpu.preprocess import Texts
from engine.gpu.types import Device, Pipeline, VertexAttribute
from engine.materials.effect import Effect, load_effect
from engine.materials.features import FeatureSet
from engine.materials.merge import SUFFIX, candidates
from engine.materials.suggest import hint
from engine.materials.variant import (
    MAGENTA,
    Begun,
    Compiled,
    Description,
    StateOptions,
    Variant,
    VariantRequest,
    absent_features,
    compile_nowhere,
    compile_variant,
    describe,
    let_go,
    shader_file,
    shadowing,
)
from engine.materials.versions import Version

#: (a reloaded effect) -> further requests that must compile before it is taken over
Further = Callable[[Effect], Iterable[tuple[Device, VariantRequest]]]


#: folders of plug-ins with effects and shaders, for the libraries made from now on
EXTRA_FOLDERS: list[Path] = []


class EffectLibrary:
    """`search`: folders with shaders (`effects/x.effect.toml`, `lib/y.glsl`); the first that has a file counts.

    `compiled` counts compilations. `errors`: effect name -> why its newest files are not in use. While there is one,
    new variants too are made from the last good contents of the files. `revision` grows when pipelines that were given
    out are let go: ask for them again.

    Pipelines are compiled when they are asked for; `begin` has the driver start on one before that, where it can.
    """

    def __init__(self, search: Sequence[Path], *, prelude: str = "") -> None:
        folders = [Path(folder) for folder in search]
        #: the built-in effects come last, those of plug-ins before them
        self.search = (*folders[:-1], *EXTRA_FOLDERS, *folders[-1:])
        self.prelude = prelude
        self.compiled = 0
        self.revision = 0
        self.errors: dict[str, LucarnaError] = {}
        #: for experiments: another variant in the place of the one that is asked for (engine.app.feature_pixels)
        self.stand_in: Callable[[VariantRequest], VariantRequest] | None = None
        self._effects: dict[str, Effect] = {}
        self._variants: dict[tuple[int, VariantRequest], Variant] = {}
        self._watched = Watched()
        #: effect name -> contents of the files that its variants are made from
        self._texts: dict[str, dict[Path, str]] = {}
        self._begun: dict[tuple[int, VariantRequest], Begun] = {}
        #: the last good version of effects that `poll` took over and nobody settled
        self._before: dict[str, Version] = {}
        #: the version of effects that `go_back` took out of use
        self._refused: dict[str, Version] = {}

    # --- effects ---

    def names(self) -> list[str]:
        """The names of all effects in the search folders."""
        return sorted(candidates(self.search))

    def get(self, name: str) -> Effect:
        """The effect, loaded once. Raises InputError (did you mean) for an unknown one, ShaderError for a bad one."""
        effect = self._effects.get(name)
        if effect is None:
            try:
                effect = self._effects[name] = self._load(name)
            except LucarnaError as error:
                self._watch([*self._folders(), *candidates(self.search).values()])
                if name in candidates(self.search):
                    self.errors[name] = error
                raise
            self.errors.pop(name, None)
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
        """As `pipeline`, but what does not compile is drawn in magenta; by Lucarna's own vertex shader if the effect's
        is bad too (nothing, where that one cannot stand in).

        The error is that of the newest source, also where the last good pipeline is still drawn.
        """
        name = effect if isinstance(effect, str) else effect.name
        request = VariantRequest(name, role, features, attributes, defines=_items(defines), prelude=prelude, **state)
        return self.of_request(device, request, effect if isinstance(effect, Effect) else None)

    def of_request(
        self, device: Device, request: VariantRequest, effect: Effect | None = None
    ) -> tuple[Pipeline, ShaderError | None]:
        """As `pipeline_or_magenta`."""
        if self.stand_in is not None:
            request = self.stand_in(request)
        variant = self._variant(device, effect or request.effect, request)
        if variant.pipeline is not None:
            return variant.pipeline, variant.error
        if variant.fallback is None:
            variant.fallback = self._magenta(variant)
        return variant.fallback, variant.error

    def computing(self, device: Device, request: VariantRequest, effect: Effect | None = None) -> Variant:
        """The variant of a technique that computes; without `pipeline` where none of its sources ever compiled."""
        return self._variant(device, effect or request.effect, request)

    def variants(self) -> list[Variant]:
        """All variants asked for so far, in that order."""
        return list(self._variants.values())

    def description(self, variant: Variant) -> Description:
        """What a variant is made of: its state, and its flattened sources with the origin of each line. Raises
        ShaderError where the newest files have a mistake and no others were good."""
        effect = self._effects[variant.request.effect]
        texts = dict(self._texts.get(effect.name, {}))
        return describe(effect, self._with_prelude(variant.request), self.search, texts=texts, caps=variant.device.caps)

    def _variant(self, device: Device, effect: Effect | str, request: VariantRequest) -> Variant:
        key = (id(device), request)
        variant = self._variants.get(key)
        if variant is not None:
            variant.asked = True
        else:
            if isinstance(effect, Effect):
                current = self._effects.setdefault(effect.name, effect)
                self._watch(current.files)
            else:
                current = self.get(effect)
            variant = self._variants[key] = self._new(device, current, request)
        return variant

    def _new(self, device: Device, effect: Effect, request: VariantRequest) -> Variant:
        variant = self._described(device, effect, request)
        ahead = self._begun.pop((id(device), request), None)
        outcome = self._compile(device, effect, request, self._texts.setdefault(effect.name, Texts()), ahead)
        self._adopt(variant, outcome)
        return variant

    @staticmethod
    def _described(device: Device, effect: Effect, request: VariantRequest) -> Variant:
        """A variant without pipeline, with what is known of its features."""
        active = effect.active(request.role, request.features)
        level, why = effect.technique(request.role).at(request.level, device.caps)
        told = request.features if isinstance(request.features, FeatureSet) else FeatureSet()
        return Variant(
            request, device, active,
            {name: told.reasons.get(name, "asked for") for name in active},
            absent_features(effect, request.role, request.features, told.dropped),
            level=level.level if level is not None else "", level_reason=why,
        )  # fmt: skip

    def _compile(
        self, device: Device, effect: Effect, request: VariantRequest, texts: dict[Path, str],
        ahead: Begun | None = None,
    ) -> Compiled | ShaderError:  # fmt: skip
        self._watch(shader_file(name, self.search) for name in effect.technique(request.role).files)
        self.compiled += 1
        try:
            request = self._with_prelude(request)
            result = compile_variant(device, effect, request, self.search, texts=texts, ahead=ahead)
        except ShaderError as error:
            self._watch(self._folders())
            return error
        self._watch(result.files)
        return result

    def _magenta(self, variant: Variant) -> Pipeline:
        effect = self._effects[variant.request.effect]
        request = self._with_prelude(variant.request)
        for magenta, search in (("fragment", self.search), ("plain", self.search[-1:])):
            self.compiled += 1
            try:
                return compile_variant(variant.device, effect, request, search, magenta=magenta).pipeline
            except ShaderError:
                continue
        return compile_nowhere(variant.device, variant.request)

    def _with_prelude(self, request: VariantRequest) -> VariantRequest:
        return replace(request, prelude=self.prelude + request.prelude) if self.prelude else request

    def _adopt(self, variant: Variant, outcome: Compiled | ShaderError) -> None:
        if isinstance(outcome, ShaderError):
            variant.error = outcome
            return
        let_go(variant)
        variant.pipeline, variant.files, variant.source_hash = outcome.pipeline, outcome.files, outcome.source_hash
        variant.compile_ms, variant.loaded, variant.reads = outcome.ms, outcome.pipeline.loaded, outcome.reads

    def prepare(self, device: Device, requests: Iterable[VariantRequest]) -> ShaderError | None:
        """Compile variants that are about to be asked for; the error of the first that does not, and nothing is kept
        of that one. Raises InputError for a role or feature that the effect has not."""
        for request in requests:
            variant = self._variant(device, request.effect, request)
            if variant.pipeline is None:
                error = variant.error
                let_go(variant)
                del self._variants[id(device), request]
                return error
        return None

    def begin(self, device: Device, request: VariantRequest) -> bool:
        """Start compiling a variant that is about to be asked for; True when asking will not wait. Its mistakes are
        told to who asks."""
        key = (id(device), request)
        if key in self._variants:
            return True
        if key not in self._begun:
            start = time.perf_counter()
            try:
                effect = self.get(request.effect)
                texts = self._texts.setdefault(effect.name, Texts())
                desc = describe(effect, self._with_prelude(request), self.search, texts=texts, caps=device.caps)
            except LucarnaError:
                return True
            ready = device.begin_pipeline(desc)
            self._begun[key] = Begun(device, desc, 1e3 * (time.perf_counter() - start))
            return ready
        return device.begin_pipeline(self._begun[key].desc)

    def abandon(self) -> None:
        """Let go what was begun and nobody asked for."""
        for device in {id(begun.device): begun.device for begun in self._begun.values()}.values():
            device.abandon_pipelines()
        self._begun.clear()

    def expect(self) -> None:
        """Begin to note which variants are asked for."""
        for variant in self._variants.values():
            variant.asked = False

    def retire(self) -> int:
        """Let variants go that no one asked for since `expect`; returns how many."""
        idle = [key for key, variant in self._variants.items() if not variant.asked]
        for key in idle:
            let_go(self._variants.pop(key))
        self.revision += bool(idle)
        return len(idle)

    def keep_only(self, kept: Iterable[Variant]) -> None:
        """Let all other variants go."""
        wanted = {id(variant) for variant in kept}
        for key in [key for key, variant in self._variants.items() if id(variant) not in wanted]:
            let_go(self._variants.pop(key))
        self.revision += 1

    def release(self) -> None:
        """Let all pipelines go."""
        for variant in self._variants.values():
            let_go(variant)
        self.abandon()
        self._variants.clear()
        self.revision += 1

    # --- hot reload ---

    def changed(self) -> set[Path]:
        """The watched files whose mtime or size is not what `poll` saw last."""
        return self._watched.changed()

    def invalidate(self) -> None:
        """Make the next `poll` take all files for changed, also those of a version that was refused."""
        self._watched.invalidate()
        self._refused.clear()

    def poll(self, further: Further | None = None) -> list[str]:
        """Look whether files changed (mtime and size); compile aside, and return the effects that now are new ones.

        All variants of an effect change together, or none: when one that was good does not compile any more, or the
        effect file is wrong, the effect stays as it was and `errors` says why. After a change, ask for pipelines again,
        and (if `get` gives another Effect) move the tables with `MaterialTable.migrate`. `further`: what the new effect
        will be asked for; it must compile too.
        """
        changed = self._watched.take()
        return [name for name in list(self._effects) if changed & self._files(name) and self._reload(name, further)]

    def _files(self, name: str) -> set[Path]:
        effect = self._effects[name]
        files = set(effect.files)
        for technique in effect.techniques.values():
            files |= {shader_file(file, self.search) for file in technique.files}
        for variant in self._of(name):
            files |= set(variant.files)
            files |= {Path(variant.error.where.file)} if variant.error is not None else set()
        if any(variant.fallback is not None for variant in self._of(name)):
            files.add(shader_file(MAGENTA, self.search))
        if name in self.errors or any(variant.error is not None for variant in self._of(name)):
            files |= self._folders()  # what is missing may come
        return files.union(shadowing(files, self.search))

    def _folders(self) -> set[Path]:
        """The search folders and the folders in them."""
        inner = {path for folder in self.search if folder.is_dir() for path in folder.iterdir() if path.is_dir()}
        return inner.union(self.search)

    def _of(self, name: str) -> list[Variant]:
        return [variant for variant in self._variants.values() if variant.request.effect == name]

    def _reload(self, name: str, further: Further | None) -> bool:
        old = self._effects[name]
        texts: dict[Path, str] = Texts()
        self.abandon()
        try:
            effect = load_effect(candidates(self.search).get(name, old.files[0]), search=self.search)
        except LucarnaError as error:
            self.errors[name] = error
            return False
        self._watch(effect.files)
        if effect.source_hash == old.source_hash and effect.files == old.files:
            effect = old
        outcomes: list[tuple[Variant, Compiled | ShaderError]] = []
        gone: list[Variant] = []
        for variant in self._of(name):
            try:
                effect.active(variant.request.role, variant.request.features)
            except InputError:
                gone.append(variant)
                continue
            outcomes.append((variant, self._compile(variant.device, effect, variant.request, texts)))
        try:
            new = self._further(effect, further, texts) if effect is not old else []
        except InputError as error:  # it has no technique for what its materials are drawn in
            self.errors[name] = error
            for _, outcome in outcomes:
                if not isinstance(outcome, ShaderError):
                    outcome.pipeline.release()
            return False
        bad = [(variant, out) for variant, out in outcomes if isinstance(out, ShaderError)]
        worse = [error for variant, error in bad if variant.pipeline is not None]
        worse += [out for _, out in new if isinstance(out, ShaderError)]
        refused = self._refused.get(name)
        if not worse and refused is not None and refused.error is not None and refused.says(effect, texts):
            worse = [refused.error]
        if worse or bad:
            self.errors[name] = (worse or [bad[0][1]])[0]
        else:
            self.errors.pop(name, None)
        mine = self._of(name)
        if not worse and mine and all(variant.pipeline is not None for variant in mine):
            self._before.setdefault(name, Version(old, self._texts.get(name, {})))
        for variant, outcome in outcomes:
            if not worse or isinstance(outcome, ShaderError):
                self._adopt(variant, outcome)
            else:
                outcome.pipeline.release()
        for (device, request), outcome in new:
            if isinstance(outcome, ShaderError):
                continue
            if worse:
                outcome.pipeline.release()
                continue
            variant = self._variants[id(device), request] = self._described(device, effect, request)
            self._adopt(variant, outcome)
        if worse:
            return False
        self._effects[name] = effect
        self._texts[name] = texts
        self._refused.pop(name, None)
        self.revision += 1
        for variant in gone:
            let_go(variant)
        self._variants = {key: variant for key, variant in self._variants.items() if variant not in gone}
        return True

    def versions(self, name: str) -> tuple[Version, Version] | None:
        """(the last good version, the one that `poll` took over since); None where there is no good one to go back to,
        or the new one is settled."""
        before = self._before.get(name)
        return None if before is None else (before, Version(self._effects[name], self._texts.get(name, {})))

    def settle(self, name: str) -> None:
        """The version in use is the good one now."""
        self._before.pop(name, None)

    def go_back(self, name: str, error: ShaderError) -> bool:
        """Run the version before the one that `poll` took over; `errors` has `error` until the files change. False
        where there is none. Then ask for pipelines again, and move the tables."""
        versions = self.versions(name)
        if versions is None:
            return False
        before, new = versions
        self._refused[name] = replace(new, error=error)
        self._run(name, before)
        self.errors[name] = error
        return True

    def go_forward(self, name: str) -> bool:
        """Run the newest version, which `go_back` took out of use, all the same. False where that is not what
        stands."""
        refused = self._refused.get(name)
        if refused is None or self.errors.get(name) is not refused.error:
            return False
        del self._refused[name], self.errors[name]
        self._run(name, refused)
        return True

    def _run(self, name: str, version: Version) -> None:
        """Another version, made from its texts when it is asked for."""
        self.abandon()
        for key in [key for key in self._variants if key[1].effect == name]:
            let_go(self._variants.pop(key))
        self._effects[name], self._texts[name] = version.effect, dict(version.texts)
        self._before.pop(name, None)
        self.revision += 1

    def _further(
        self, effect: Effect, further: Further | None, texts: dict[Path, str]
    ) -> list[tuple[tuple[Device, VariantRequest], Compiled | ShaderError]]:
        found: dict[tuple[int, VariantRequest], tuple[tuple[Device, VariantRequest], Compiled | ShaderError]] = {}
        for device, request in further(effect) if further is not None else ():
            key = (id(device), request)
            if key not in self._variants and key not in found:
                found[key] = ((device, request), self._compile(device, effect, request, texts))
        return list(found.values())

    def _watch(self, files: Iterable[Path]) -> None:
        known = list(files)
        self._watched.add((*known, *shadowing(known, self.search)))


def _items(defines: Mapping[str, str | int] | None) -> tuple[tuple[str, str | int], ...]:
    return tuple(sorted(defines.items())) if defines else ()
