"""Session: everything the window works on, and what a user can do with it. No imgui, no GL.

Panels read it and call it; operations are its named actions; tests drive it without a window.
"""

from collections.abc import Callable, Hashable, Mapping, Sequence
from pathlib import Path
from typing import Any

from editor import dropping, prefab_updates, recovering, reimporting, replacing, saving, tabs, work
from editor.animating import following
from editor.animating.view import AnimatingView
from editor.commands.command import VIEW_TABLE, Edit
from editor.commands.history import History
from editor.document import Document
from editor.looking import Looking
from editor.opening import OpenJob
from editor.playback import Playback
from engine.core.errors import LucarnaError


class Session(Looking):
    """What a user can do: open, edit, save, close, quit. The fields are SessionState's."""

    __slots__ = ()

    # --- opening ---

    def open(self, path: Path, *, again: bool = False) -> None:
        """Start to open a project, folder, source or scene in a tab of its own; one that is open already comes to the
        front, or with `again` is read anew, after asking when it has unsaved changes."""
        index = tabs.find(self, path)
        if index >= 0:
            tabs.show(self, index)
            if not again:
                self.ui.welcome = False
                return
            if self.document is not None and self.document.dirty:
                self.ask_discard(lambda: self._start(path))
                return
        self._start(path)

    def poll(self) -> None:
        """Once a frame: take over what a finished job found, and files that were edited. The present document stays
        until the next one is good."""
        self.shaders.poll(self)
        self.asset_pictures.pump(self)
        work.step(self)
        self._take_over()
        reimporting.poll(self)
        prefab_updates.poll(self)
        dropping.go_on(self)

    def _take_over(self) -> None:
        job = self.job
        if job is None or not job.done:
            return
        self.job = None
        if job.error is not None:
            self.fail(job.error)
        elif job.result is None:
            self.messages.info(f"Opening {job.path.name} was cancelled")
        else:
            try:
                with self.device_frame():
                    root = shader_root(job.result)
                    runtime = self.host.open_runtime(self.device, job.result.scene, root)
            except LucarnaError as error:
                self.messages.findings(job.result.findings)
                self.fail(error)
                return
            self.adopt(Document(job.result, runtime))

    def adopt(self, document: Document, *, beside: bool = False) -> None:
        """Put `document` in front, in a tab of its own; where its source is open already, in the place of that one,
        which is closed, and the camera stays. `beside`: it keeps its own tab even then."""
        index = -1 if beside else tabs.find(self, document.source)
        again = index >= 0
        if again:
            tabs.show(self, index)
            camera = self.camera
            self.close(keep_empty=True)
            self.tabs.insert(index, tabs.Tab(document))
            self.camera = camera
        else:
            tabs.park(self)
            self.tabs.append(tabs.Tab(document))
        self.document = document
        replacing.watch(self, document)
        self.ui.error_bar = ""
        self.messages.findings(document.findings)
        runtime_findings = getattr(document.runtime, "findings", None)
        if runtime_findings is not None:
            self.messages.findings(f for f in runtime_findings if f not in document.findings.items)
        scene = document.runtime.scene
        nodes, draws = len(scene.nodes.name), len(scene.instances.node)
        self.messages.info(f"Opened {document.name}: {nodes} nodes, {draws} drawn parts", where=str(document.source))
        self.playback = Playback(duration=float(document.runtime.duration))
        self.followed, self.animating = None, AnimatingView()
        self.drawing_noted = (None, None)
        self.playback.playing = self.playback.available and (self.show_off or not self.software)
        self.show_off = False
        document.runtime.update(0.0)
        if not again:
            self.reset_camera()
        if self.select_on_open in scene.nodes.name:
            document.select(list(scene.nodes.name).index(self.select_on_open))
        self.preferences.add_recent(document.source)
        self.remember()
        document.prefabs = replacing.prefabs_of(document.runtime, document.scene_path)
        recovering.start(self, document)
        reimporting.welcome(self, document)

    def close(self, *, keep_empty: bool = False) -> None:
        """Close the document in front, if any, without asking; the next tab comes to the front, unless `keep_empty`."""
        document, index = self.document, tabs.front(self)
        if document is None:
            return
        if self.journal is not None:
            self.journal.finish()
        tabs.clear(self)
        self.tabs.pop(index)
        with self.device_frame():
            self.history_pictures.forget(document)
            document.close()
        if self.tabs and not keep_empty:
            tabs.show(self, min(index, len(self.tabs) - 1))

    def close_all(self) -> None:
        """Close every document without asking."""
        while self.document is not None:
            self.close()

    def ask_discard(self, then: Callable[[], None], *, everything: bool = False) -> None:
        """Let the user say what becomes of unsaved changes, of the document in front or of `everything`, then go on."""
        self.ui.after_discard, self.ui.discard_all = then, everything

    # --- editing ---

    def edit(
        self,
        table: str,
        column: str,
        rows: Sequence[int],
        values: Sequence[Any],
        *,
        gesture: Hashable | None = None,
        label: str = "",
    ) -> None:
        """Document.edit, with a bad value logged instead of raised."""
        if self.document is None:
            return
        try:
            self.document.edit(table, column, rows, values, gesture=gesture, label=label)
        except LucarnaError as error:
            self.messages.error(error)

    def apply_settings(self, values: Mapping[str, Any], label: str = "") -> None:
        """Set several render settings as one entry of the undo history; a bad value is logged and changes nothing."""
        known = {p.name: p for p in self.settings.PARAMS}
        names = [name for name in values if name in known]
        try:
            checked = tuple(known[name].check(values[name]) for name in names)
        except LucarnaError as error:
            self.messages.error(error)
            return
        if names:
            self.edit(VIEW_TABLE, ",".join(names), (0,), (checked,), label=label or "Change render settings")

    def end_gesture(self) -> None:
        if self.document is not None:
            self.document.history.end_gesture()

    def undo(self) -> None:
        """What cannot be undone (files that were moved are gone) is in the error bar, and stays to be undone."""
        self._travel("Undone", lambda history: history.undo())

    def redo(self) -> None:
        self._travel("Redone", lambda history: history.redo())

    def go_to(self, entries: int) -> None:
        """Undo or redo until so many entries are done, as far as that can be."""

        def go(history: History) -> Edit | None:
            history.go_to(entries)
            return history.last

        self._travel("After", go)
        if self.document is not None and not self.document.history.entries:
            self.ui.notice = "As it was opened"

    def _travel(self, done: str, go: Callable[[History], Edit | None]) -> None:
        try:
            command = go(self.document.history) if self.document is not None else None
        except LucarnaError as error:
            self.fail(error)
            return
        if command is not None:
            self.ui.notice = f"{done}: {command.describe()}"
            following.follow(self)

    def thumbnail(self, material: int, slot: str) -> int:
        """The native id of a small picture of the texture in a material's slot; 0 where there is none."""
        if self.document is None or self.null_pictures:
            return 0
        texture, layer = self.document.runtime.residency.materials.slot_texture(material, slot)
        with self.device_frame():
            return self.thumbnails.get(self.device, texture, layer)

    def set_visible(self, rows: Sequence[int], visible: bool) -> None:
        verb = "Show" if visible else "Hide"
        what = self.node_name(rows[0]) if len(rows) == 1 else f"{len(rows)} nodes"
        self.edit("nodes", "visible", rows, [visible] * len(rows), label=f"{verb} {what}")

    def save(self, target: Path | None = None) -> bool:
        """Save to `target`, or where the document belongs; asks for a place when it has none. True when written."""
        document = self.document
        if document is None:
            return False
        target = target or saving.default_target(document)
        if target is None:
            self.ui.save_dialog = True
            return False
        try:
            written = saving.save_document(document, target)
        except LucarnaError as error:
            self.fail(error)
            return False
        document.saved_to = target
        document.history.mark_saved()
        if len(written) > 1:  # our own files are taken up now: later, they would undo what was edited since
            self.shaders.reload(self, force=False)
            for runtime in document.parked:
                runtime.residency.saved_elsewhere(written)
        more = f" and {len(written) - 1} more files" if len(written) > 1 else ""
        self.ui.notice = f"Saved {target.name}{more}"
        self.messages.info(self.ui.notice, where=str(target))
        return True

    # --- shaders ---

    def open_code(self, path: Path, line: int = 0, column: int = 0) -> None:
        """Show a file in the shader editor, at a place; a file that cannot be read is an error in the log."""
        try:
            self.code.open(path, line, column)
        except LucarnaError as error:
            self.fail(error)
            return
        self.ui.focus_panel = "Shader editor"

    def save_code(self) -> bool:
        """Save the text in front and bring it to the screen; True when it was written."""
        document = self.code.front
        if document is None:
            return False
        try:
            written = document.save()
        except LucarnaError as error:
            self.fail(error)
            return False
        if document.conflict:
            self.ui.notice = f"{document.name} was changed elsewhere too"
        if written:
            self.shaders.reload(self, force=False)
        return written

    def copy_code_into_project(self) -> None:
        """Put a copy of the built-in file in front into the project, and edit that."""
        if self.document is None or self.code.front is None:
            return
        try:
            copy = self.code.copy_into(self.code.front, shader_root(self.document))
        except LucarnaError as error:
            self.fail(error)
            return
        self.messages.info(f"Copied {copy.name} into the project", where=str(copy.path))

    # --- time ---

    def tick(self, seconds: float) -> None:
        """Advance the clock by wall time."""
        following.follow(self)
        if self.document is not None and self.playback.tick(seconds):
            states = following.drive_of(self) == "states"
            self.document.runtime.update(self.playback.elapsed if states else self.playback.time)
        following.report(self)

    def seek(self, time: float) -> None:
        self.playback.seek(time)
        if self.document is not None:
            if following.drive_of(self) == "states":
                following.runtime_of(self).seek(self.playback.time)
            else:
                self.document.runtime.update(self.playback.time)

    # --- the rest ---

    def request_quit(self) -> bool:
        """True when the window may close now; else the user is asked first."""
        if self.unsaved and not self.ui.quit:
            self.ask_discard(self._quit, everything=True)
            return False
        return True

    @property
    def unsaved(self) -> list[str]:
        """Names of what has unsaved changes: documents, texts."""
        changed = [document.name for document in tabs.documents(self) if document.dirty]
        return changed + [text.name for text in self.code.dirty]

    @property
    def asked_about(self) -> list[str]:
        """Names of the unsaved changes that the question about them is about."""
        if self.ui.discard_all:
            return self.unsaved
        return [self.document.name] if self.document is not None and self.document.dirty else []

    def save_all(self) -> bool:
        """Save all documents and texts; False when something could not be, or must be asked first: it is in front."""
        for text in self.code.dirty:
            self.code.front = text
            self.code.raise_tab = True
            if not self.save_code():
                return False
        came_from = self.document
        for index, document in enumerate(tabs.documents(self)):
            if document.dirty:
                tabs.show(self, index)
                if not self.save():
                    return False
        tabs.show(self, next((i for i, tab in enumerate(self.tabs) if tab.document is came_from), -1))
        return True

    def discard(self) -> None:
        """The user gives up the unsaved changes that the question was about."""
        for document in tabs.documents(self):
            if self.ui.discard_all or document is self.document:
                document.history.mark_saved()

    def _quit(self) -> None:
        self.ui.quit = True

    def _start(self, path: Path) -> None:
        path = path.resolve()
        if self.job is not None:
            self.job.cancel()
        self.ui.welcome = False
        self.messages.info(f"Opening {path.name}", where=str(path))
        self.job = OpenJob(self.host, path)


def shader_root(opened: Any) -> Path:
    """The folder whose effects and shaders go before the built-in ones, of a resolved path or a document: the
    project's, else that of the file itself."""
    if opened.project_root is not None:
        return Path(opened.project_root)
    source: Path = opened.source
    return source if source.is_dir() else source.parent
