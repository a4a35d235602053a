"""HotReload: edited effects, shaders, materials and IES files come to the screen; what is wrong keeps the last picture.

    files change (mtime and size, looked at four times a second) ──► compile aside
        all good ──► new pipelines, material tables migrated, structure_rev raised ──► next frame is the new picture
        any bad  ──► nothing changes; `problems` says what, where (file:line:column) and what to do

An effect is only taken over when every variant that is drawn, and every one that its materials will ask for then, does
compile. So is a material whose features changed. Values set in the editor outlive it all.

The first picture by a new version is looked into before anyone sees it (`prove`): one that writes NaN or an infinity
where the last good version has none goes back. Later frames are not looked into.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

from engine.core.errors import InputError, LucarnaError, Place, ShaderError
from engine.core.toml_source import with_caret
from engine.gpu.types import Device
from engine.materials.effect import Effect
from engine.materials.fit import fitted
from engine.materials.library import EffectLibrary
from engine.materials.variant import VariantRequest, shader_file
from engine.materials.versions import changes
from engine.report.number_check import NumberReport, NumberRow
from engine.resources.material_store import MaterialRecord
from engine.resources.residency import Residency

#: seconds between two looks at the files
INTERVAL = 0.25


class PassPrograms(Protocol):
    """What is asked of engine.render.programs.Programs."""

    pass_errors: dict[str, ShaderError]

    def forget(self) -> None: ...
    def changed(self) -> bool: ...
    def invalidate(self) -> None: ...
    def poll(self) -> list[str]: ...
    def has_own(self, fragment: str) -> bool: ...
    def versions(self, fragment: str) -> tuple[dict[Path, str], dict[Path, str]] | None: ...
    def settle(self, fragment: str) -> None: ...
    def go_back(self, fragment: str, error: ShaderError) -> bool: ...
    def go_forward(self, fragment: str) -> bool: ...


class Profiles(Protocol):
    """What is asked of engine.render.light_tables.LightTables."""

    errors: dict[Path, InputError]

    def changed(self) -> bool: ...
    def invalidate(self) -> None: ...
    def reread(self) -> list[Path]: ...
    def kept(self, path: Path) -> bool: ...


class Draws(Protocol):
    """What is asked of engine.render.renderer.Renderer."""

    @property
    def programs(self) -> PassPrograms: ...
    @property
    def profiles(self) -> Profiles: ...
    @property
    def frames(self) -> int: ...
    def requests(self, records: Mapping[int, MaterialRecord]) -> list[VariantRequest]: ...


@dataclass(frozen=True, slots=True)
class Reloaded:
    """What a look at changed files led to: what is new on screen, and what stands in the way now."""

    effects: tuple[str, ...] = ()
    materials: tuple[Path, ...] = ()
    passes: tuple[str, ...] = ()
    profiles: tuple[Path, ...] = ()
    problems: tuple[LucarnaError, ...] = ()
    ms: float = 0.0
    textures: tuple[Path, ...] = ()

    @property
    def names(self) -> list[str]:
        return [*self.effects, *self.passes, *(path.name for path in (*self.materials, *self.profiles, *self.textures))]


class NotFinite(ShaderError):
    """A new version compiles, but writes NaN or infinities."""


class HotReload:
    """Call `poll` every frame: it does nothing most times. `problems`: what is wrong now, each with its place."""

    def __init__(self, residency: Residency, renderer: Draws, *, interval: float = INTERVAL) -> None:
        self.residency = residency
        self.renderer = renderer
        self.interval = interval
        self._looked = -1e9
        self._materials = residency.watched_materials
        self._unfit: dict[str, list[InputError]] = {}
        self._forgot_at = -1
        #: effects and passes that were taken over and whose numbers nobody has looked at yet
        self.unproven: tuple[str, ...] = ()
        #: how often `prove` was called
        self.proofs = 0
        self._refused: tuple[str, ...] = ()
        self._nonfinite: LucarnaError | None = None

    @property
    def problems(self) -> tuple[LucarnaError, ...]:
        """All that stands, each once: effects, passes, material files."""
        return tuple(error for _, error in self.standing())

    def standing(self) -> list[tuple[str, LucarnaError]]:
        """(what is shown meanwhile, what is wrong), each error once. previous: the last good version; built-in:
        Lucarna's own instead of the project's; magenta; ignored: all but that; nonfinite: the new version, which
        compiles but writes NaN, as the one before did or because it was asked for."""
        found: dict[str, tuple[str, LucarnaError]] = {}
        for state, error in self._problems():
            found.setdefault(str(error), (state, error))
        return list(found.values())

    def stale(self) -> bool:
        """Whether a file changed since the last `apply`. Any thread may ask."""
        effects, programs = self.residency.effects, self.renderer.programs
        profiles = self.renderer.profiles
        own = self._materials.changed() or self.residency.textures.changed()
        return bool(effects.changed() or own or programs.changed() or profiles.changed())

    def changed(self, now: float | None = None) -> bool:
        """Whether there is something for `apply` to do; looks at the files at most once per interval."""
        now = time.monotonic() if now is None else now
        if now - self._looked < self.interval:
            return False
        self._looked = now
        return self.stale()

    def poll(self, now: float | None = None, *, force: bool = False) -> Reloaded | None:
        """Look, and take over what is good; None when no file changed. `force` takes all files for changed."""
        if not force and not self.changed(now):
            return None
        if force:
            self.invalidate()
        return self.apply()

    def invalidate(self) -> None:
        """Take all files for changed."""
        renderer = self.renderer
        residency = self.residency
        for watched in (residency.effects, renderer.programs, self._materials, renderer.profiles, residency.textures):
            watched.invalidate()

    def apply(self) -> Reloaded:
        """Take over what is good of the files as they are now. Between the device's begin_frame and end_frame."""
        begun = time.perf_counter()
        effects = self.residency.effects
        if 0 <= self._forgot_at < self.renderer.frames:
            effects.retire()
            self._forgot_at = -1
        changed_effects = bool(effects.changed())
        names = effects.poll(self._further)
        for name in names:
            self._unfit[name] = self.residency.adopt_effect(name)
        passes = self.renderer.programs.poll()
        materials = self._reread(self._materials.take(), retry=changed_effects)
        if names or passes:
            self.unproven = tuple(dict.fromkeys((*self.unproven, *names, *passes)))
            self._nonfinite = None
        if names or passes or materials:
            self._ask_again()
        profiles = self.renderer.profiles.reread()
        textures = self.residency.reread_textures()
        if profiles or textures:
            self.residency.materials.structure_rev += 1
        ms = 1e3 * (time.perf_counter() - begun)
        return Reloaded(
            tuple(names), tuple(materials), tuple(passes), tuple(profiles), self.problems, ms, tuple(textures)
        )

    def prove(self, draw: Callable[[], NumberReport | None]) -> bool:
        """Look into the numbers of the picture by the new versions; see `unproven`. `draw` makes one with the versions
        in use, shows it to nobody, and gives what the check found.

        Where there is NaN or an infinity that the last good versions' picture has not, these run again and `problems`
        says why. Where these have it too, the new ones are taken. Whether what was drawn last is by those in use now.
        """
        names, self.unproven = self.unproven, ()
        self.proofs += 1
        first = _first(draw())
        if first is None:
            for name in names:
                self._part(name).settle(name)
            return True
        error = self._not_finite(names, first)
        back = tuple(name for name in names if self._part(name).go_back(name, error))
        if back:
            self._swapped(back)
            if _first(draw()) is None:
                self._refused = back
                return True
            for name in back:
                self._part(name).go_forward(name)
            self._swapped(back)
        self._nonfinite = error
        return not back

    @property
    def refused(self) -> tuple[str, ...]:
        """Effects and passes whose newest version compiles, but was sent back by `prove`."""
        effects, passes = self.residency.effects.errors, self.renderer.programs.pass_errors
        stands = [*effects.values(), *passes.values()]
        return self._refused if any(isinstance(error, NotFinite) for error in stands) else ()

    def draw_anyway(self) -> tuple[str, ...]:
        """Take what `prove` sent back all the same; the names. Between the device's begin_frame and end_frame."""
        errors = {**self.residency.effects.errors, **self.renderer.programs.pass_errors}
        taken = tuple(name for name in self.refused if self._part(name).go_forward(name))
        if taken:
            told = errors[taken[0]]
            self._nonfinite = told
            self._swapped(taken)
        self._refused = ()
        return taken

    # --- inside ---

    def _part(self, name: str) -> EffectLibrary | PassPrograms:
        """Who has the versions of an effect, or of a pass shader, which is named like a file."""
        return self.renderer.programs if Path(name).suffix else self.residency.effects

    def _swapped(self, names: Iterable[str]) -> None:
        """Another version of these is in use."""
        for name in names:
            if not Path(name).suffix:
                self._unfit[name] = self.residency.adopt_effect(name)
        self._ask_again()

    def _ask_again(self) -> None:
        self.residency.materials.structure_rev += 1
        self.renderer.programs.forget()
        self.residency.effects.expect()
        self._forgot_at = self.renderer.frames

    def _not_finite(self, names: Iterable[str], first: NumberRow) -> NotFinite:
        """The error, at the place where the edit begins as far as that can be told."""
        effects = self.residency.effects
        texts: dict[Path, str] = {}
        places: list[Place] = []
        for name in names:
            if Path(name).suffix:
                passes = self.renderer.programs.versions(name)
                old, new = passes or ({}, {})
            else:
                both = effects.versions(name)
                old, new = (dict(both[0].texts), dict(both[1].texts)) if both is not None else ({}, {})
            texts |= new
            places += [place for place in changes(old, new) if place not in places]
        told = f"{', '.join(names)} compiles, but pass {first.pass_name!r} now leaves {first.describe()}"
        hint = "guard divisions, roots and logarithms of 0; the view 'nonfinite' shows where"
        if not places:
            files = [shader_file(f, effects.search) for name in names for f in self._fragments(name)]
            return NotFinite(told, where=files[0] if files else None, hint=hint)
        where, *others = places
        told += f"; the change begins at line {where.line}"
        told += f" (also changed: {', '.join(Path(p.file).name for p in others)})" if others else ""
        return NotFinite(with_caret(told, texts[Path(where.file)], where), where=where, hint=hint)

    def _fragments(self, name: str) -> list[str]:
        """The fragment shaders of an effect, or the pass shader of that name."""
        if Path(name).suffix:
            return [f"passes/{name}"]
        techniques = self.residency.effects.get(name).techniques.values()
        return [file for technique in techniques for file in technique.files if file.endswith(".frag")]

    def _further(self, effect: Effect) -> Iterator[tuple[Device, VariantRequest]]:
        """The variants that a reloaded effect's materials will ask for."""
        records = {
            material: replace(record, effect=effect, asset=fitted(effect, record.said)[0])
            for material, record in enumerate(self.residency.materials.records)
            if record.effect.name == effect.name
        }
        for request in self.renderer.requests(records):
            yield self.residency.device, request

    def _reread(self, changed: set[Path], *, retry: bool) -> list[Path]:
        """The material files taken over, of those that changed and (with `retry`) those that were wrong."""
        residency = self.residency
        files = [p for p in residency.material_files if p in changed or changed & residency.parents_of(p)]
        if retry or changed:
            files += [path for path in residency.material_errors if path not in files]
        taken = []
        for path in files:
            try:
                new = residency.read_again(path)
                record = replace(residency.material(new.material), effect=new.effect, asset=new.asset)
                record.asset = fitted(new.effect, new.asset)[0]
                error = residency.effects.prepare(residency.device, self.renderer.requests({new.material: record}))
                if error is not None:
                    raise error
            except InputError as error:
                residency.material_errors[path] = error
                continue
            residency.take(new)
            residency.material_errors.pop(path, None)
            taken.append(path)
        for name, unfit in self._unfit.items():
            self._unfit[name] = [error for error in unfit if Path(error.where.file) not in taken]
        return taken

    def _problems(self) -> Iterable[tuple[str, LucarnaError]]:
        residency = self.residency
        used = {record.effect.name for record in residency.materials.records}
        failed = dict(residency.effects.errors)
        for name, error in failed.items():
            if name in used or any(str(error) == str(other) for other in residency.material_errors.values()):
                yield self._state_of(name), error
        for variant in residency.effects.variants():
            if variant.error is not None and variant.request.effect not in failed:
                yield self._state_of(variant.request.effect), variant.error
        programs = self.renderer.programs
        for fragment, error in programs.pass_errors.items():
            yield "previous" if programs.has_own(fragment) else "built-in", error
        for path, error in residency.material_errors.items():
            yield "magenta" if residency.unread(residency.material_files[path]) else "previous", error
        for path, error in residency.textures.errors.items():
            yield "previous" if residency.textures.kept(path) else "ignored", error
        for path, error in self.renderer.profiles.errors.items():
            yield "previous" if self.renderer.profiles.kept(path) else "ignored", error
        for unfit in self._unfit.values():
            for error in unfit:
                yield "ignored", error
        if self._nonfinite is not None:
            yield "nonfinite", self._nonfinite

    def _state_of(self, effect: str) -> str:
        """previous, unless a variant of the effect never was good."""
        variants = [v for v in self.residency.effects.variants() if v.request.effect == effect]
        return "magenta" if not variants or any(v.pipeline is None for v in variants) else "previous"


def _first(numbers: NumberReport | None) -> NumberRow | None:
    return numbers.first if numbers is not None else None
