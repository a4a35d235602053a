"""PluginManager: switches plug-ins on and off, and keeps the session going when one fails. No imgui."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from editor.operations import Operations
from editor.plugins import discovery
from editor.plugins.api import Plugin
from editor.plugins.discovery import Found
from editor.session import Session
from engine.core.errors import LucarnaError
from importers.plugin_importers import load_module, where_it_broke

#: seconds between two looks at the files
LOOK_EVERY = 0.5


@dataclass(slots=True, eq=False)
class Loaded:
    """`state`: on, off, failed, or waits (for the user's word). `error`: file:line: what, of a failed one."""

    name: str
    found: Found
    state: str = "off"
    error: str = ""
    plugin: Plugin | None = None
    stamp: float = 0.0
    passes: list[str] = field(default_factory=list)

    @property
    def path(self) -> Path | None:
        return self.found.path


@dataclass(slots=True, eq=False)
class PluginWindow:
    """A panel of a plug-in as a window."""

    owner: Loaded
    panel: Any
    opened: bool = True


class PluginManager:
    """`active` False (`--no-plugins`): none is looked for. Trusted projects and what is off are preferences."""

    def __init__(self, session: Session, operations: Operations, *, active: bool = True) -> None:
        self.session, self.operations, self.active = session, operations, active
        self.plugins: list[Loaded] = []
        self.windows: list[PluginWindow] = []
        self.root: Path | None = None
        #: the project whose plug-ins wait for the user's word
        self.asking: Path | None = None
        self._looked = 0.0
        from engine.render.extra_passes import EXTRA

        EXTRA.failed = self._pass_failed

    # --- which ---

    def start(self) -> None:
        """Switch the installed ones on."""
        if self.active:
            for found in discovery.installed():
                self._add(found, trusted=True)

    def poll(self) -> None:
        """Once a frame: another project, changed files."""
        if not self.active:
            return
        document = self.session.document
        root = document.project_root if document is not None else self.root
        if root != self.root:
            self.enter(root)
        if self.session.ui.reload_plugins:
            self.session.ui.reload_plugins = False
            self.reload()
        now = time.monotonic()
        if now - self._looked >= LOOK_EVERY:
            self._looked = now
            self.look()

    def enter(self, root: Path | None) -> None:
        """Another project is open: its plug-ins in the place of those of the last."""
        for loaded in [p for p in self.plugins if p.path is not None]:
            self.switch_off(loaded, "off")
            self.plugins.remove(loaded)
        self.root, self.asking = root, None
        found = discovery.of_project(root) if root is not None else []
        if not found or root is None:
            return
        trusted = str(root.resolve()) in self.session.preferences.trusted_projects
        for one in found:
            self._add(one, trusted=trusted)
        if not trusted and any(p.state == "waits" for p in self.plugins):
            self.asking = root

    def trust(self, always: bool = True) -> None:
        """The user says that the project's plug-ins may run."""
        if self.root is None:
            return
        known = self.session.preferences.trusted_projects
        if always and str(self.root.resolve()) not in known:
            known.append(str(self.root.resolve()))
            self.session.remember()
        self.asking = None
        for loaded in [p for p in self.plugins if p.state == "waits"]:
            self.switch_on(loaded)

    def decline(self) -> None:
        """Not now: they wait, listed, until somebody switches them on."""
        self.asking = None

    def _add(self, found: Found, *, trusted: bool) -> None:
        loaded = Loaded(found.name, found, "waits")
        self.plugins.append(loaded)
        if found.name in self.session.preferences.plugins_off:
            loaded.state = "off"
        elif trusted:
            self.switch_on(loaded)

    # --- on and off ---

    def switch_on(self, loaded: Loaded) -> bool:
        """Run its `register`; False, with the error listed and logged, where that raises."""
        self.switch_off(loaded, "off")
        plugin = loaded.plugin = Plugin(self, loaded)
        try:
            register = self._entry(loaded)
            register(plugin)
        except Exception as error:  # a plug-in raises what it likes: it is listed and off
            self.fail(loaded, error)
            return False
        loaded.state, loaded.error = "on", ""
        return True

    def _entry(self, loaded: Loaded) -> Callable[[Plugin], None]:
        if loaded.path is not None:
            loaded.stamp = discovery.stamp(loaded.path)
            thing: Any = load_module(loaded.path)
        else:
            assert loaded.found.entry is not None
            thing = loaded.found.entry.load()
        register = getattr(thing, "register", thing)
        if not callable(register):
            raise TypeError("a plug-in defines register(plugin)")
        made: Callable[[Plugin], None] = register
        return made

    def switch_off(self, loaded: Loaded, state: str = "off") -> None:
        """Take back all that it added."""
        plugin, loaded.plugin = loaded.plugin, None
        for undo in reversed(plugin.undo if plugin is not None else []):
            undo()
        loaded.state = state
        if plugin is not None:
            self.session.image.invalidate()

    def set_wanted(self, loaded: Loaded, wanted: bool) -> None:
        """The user's switch; remembered."""
        off = self.session.preferences.plugins_off
        if wanted:
            off[:] = [name for name in off if name != loaded.name]
            self.switch_on(loaded)
        else:
            off.append(loaded.name)
            self.switch_off(loaded)
        self.session.remember()

    def look(self) -> None:
        """Load again what was changed on disk."""
        for loaded in self.plugins:
            if loaded.path is None or loaded.state not in ("on", "failed"):
                continue
            now = discovery.stamp(loaded.path)
            if now and now != loaded.stamp and self.switch_on(loaded):
                self.session.messages.info(f"Plug-in {loaded.name} was loaded again", where=str(loaded.path))

    def files(self) -> Iterator[Path]:
        """Those that `look` looks at."""
        for loaded in self.plugins:
            if loaded.path is not None and loaded.state in ("on", "failed"):
                yield from discovery.files_of(loaded.path)

    def reload(self) -> None:
        """Load all that are on again, and look for new ones."""
        for loaded in self.plugins:
            if loaded.state in ("on", "failed"):
                self.switch_on(loaded)
        known = {p.path for p in self.plugins}
        if self.root is not None:
            trusted = str(self.root.resolve()) in self.session.preferences.trusted_projects
            for found in discovery.of_project(self.root):
                if found.path not in known:
                    self._add(found, trusted=trusted)

    # --- failing ---

    def fail(self, loaded: Loaded, error: Exception) -> None:
        """It raised: it is off, and its line is told."""
        words = where_it_broke(error, loaded.path)
        if isinstance(error, LucarnaError) and error.hint:
            words += f" ({error.hint})"
        self.switch_off(loaded, "failed")
        loaded.error = words
        if loaded.path is not None and not loaded.stamp:
            loaded.stamp = discovery.stamp(loaded.path)
        self.session.messages.error(f"Plug-in {loaded.name} was switched off: {words}")
        self.session.ui.notice = f"Plug-in {loaded.name} was switched off"

    def guard(self, loaded: Loaded, run: Callable[..., None]) -> Callable[..., None]:
        """`run`, whose failure switches the plug-in off; a LucarnaError is told, as of any operation."""

        def call(session: Session, **arguments: Any) -> None:
            try:
                run(session, **arguments)
            except LucarnaError as error:
                session.fail(error)
            except Exception as error:  # a plug-in raises what it likes: it is listed and off
                self.fail(loaded, error)

        return call

    def add_window(self, loaded: Loaded, panel: Any) -> PluginWindow:
        self.windows.append(PluginWindow(loaded, panel, panel.opened))
        return self.windows[-1]

    def _pass_failed(self, name: str, error: Exception) -> None:
        for loaded in self.plugins:
            if name in loaded.passes:
                self.fail(loaded, error)
                return
