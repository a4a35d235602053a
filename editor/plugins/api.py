"""What a plug-in's `register(plugin)` is given: the doors through which it adds things. No imgui."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from editor.arguments import Argument
from editor.operations import Operation, always
from engine.core.errors import UsageError

if TYPE_CHECKING:
    from editor.panels.base import Panel
    from editor.plugins.manager import Loaded, PluginManager
    from editor.session import Session
    from engine.framegraph.passes import Pass

MENU = "Plug-ins"


class Plugin:
    """Adds to the registries; `undo` takes each thing away again, the last first."""

    def __init__(self, manager: PluginManager, loaded: Loaded) -> None:
        self._manager, self._loaded = manager, loaded
        self.name = loaded.name
        self.folder = loaded.path.parent if loaded.path is not None else None
        self.undo: list[Callable[[], None]] = []

    @property
    def session(self) -> Session:
        return self._manager.session

    def operation(
        self, id: str, label: str, run: Callable[..., None], *, menu: str = MENU, keys: tuple[str, ...] = (),
        enabled: Callable[[Session], bool] = always, checked: Callable[[Session], bool] | None = None,
        doc: str = "", arguments: tuple[Argument, ...] = (),
    ) -> None:  # fmt: skip
        """Add an operation: menu, palette, keys, console and scripts have it at once. Raises UsageError for an id or a
        key that is taken."""
        operations = self._manager.operations
        if id in operations:
            raise UsageError(f"there is an operation {id!r} already")
        taken = [key for key in keys if key in operations.shortcuts()]
        if taken:
            raise UsageError(f"{taken[0]} is taken by {operations.shortcuts()[taken[0]]}")
        guarded = self._manager.guard(self._loaded, run)
        operations.add(Operation(id, label, guarded, menu, keys, enabled, checked, False, doc, arguments))
        self.undo.append(lambda: operations.remove(id))

    def panel(self, kind: type[Panel]) -> None:
        """Add a window; `kind` is an editor.panels.base.Panel. An operation `plugin.show-…` opens it."""
        window = self._manager.add_window(self._loaded, kind())
        self.undo.append(lambda: self._manager.windows.remove(window))
        id = "plugin.show-" + kind.title.lower().replace(" ", "-")

        def toggle(session: Session) -> None:
            window.opened = not window.opened

        self.operation(id, kind.title, toggle, checked=lambda session: window.opened)

    def importer(self, importer: Any) -> None:
        """Add an importer (importers.registry.Importer). One of a project's file must be that file's IMPORTER, which
        worker processes load too."""
        from importers import plugin_importers

        path = self._loaded.path
        if path is None:
            raise UsageError(
                "an installed plug-in names its importer as an entry point",
                hint=f"add it to the group {plugin_importers.GROUP}",
            )
        if importer.module != plugin_importers.module_name(path):
            importer = replace(importer, module=plugin_importers.module_name(path))
        plugin_importers.add_file(path)
        self.undo.append(lambda: plugin_importers.remove_file(path))

    def render_pass(self, kind: type[Pass]) -> None:
        """Add a pass (engine.framegraph.passes.Pass) that runs last, on the finished picture; see
        engine.render.screen_pass for the easy ones. Its parameters stand in the Plug-ins panel."""
        from engine.render.extra_passes import EXTRA

        EXTRA.add(kind)
        self._loaded.passes.append(kind.name)
        self.undo.append(lambda: EXTRA.remove(kind.name))
        self.undo.append(lambda: self._loaded.passes.remove(kind.name))

    def effects(self, folder: str | Path) -> None:
        """Add a folder with effects and shaders (`effects/`, `passes/`, `lib/` as in the built-in one), relative to
        the plug-in's. Materials of documents that are opened from now on find them."""
        from engine.materials.library import EXTRA_FOLDERS

        path = (self.folder or Path()) / folder
        if not path.is_dir():
            raise UsageError(f"there is no folder {path}")
        EXTRA_FOLDERS.append(path)
        self._search([path], [])
        self.undo.append(lambda: self._search([], [path]))
        self.undo.append(lambda: EXTRA_FOLDERS.remove(path))

    def _search(self, more: list[Path], fewer: list[Path]) -> None:
        """Let the open document look there too."""
        document = self.session.document
        library = getattr(getattr(document.runtime, "residency", None), "effects", None) if document else None
        if library is not None:
            kept = [folder for folder in library.search if folder not in fewer]
            library.search = (*kept[:-1], *more, *kept[-1:])
