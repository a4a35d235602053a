"""Session: everything the window works on, and what a user can do with it. No imgui, no GL.

Panels read it and call it; operations are its named actions; tests drive it without a window.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from editor import camera_controls, preferences, recovering, saving, work
from editor.animating import following
from editor.animating.view import AnimatingView
from editor.asset_thumbnails import AssetThumbnails
from editor.camera_controls import OrbitCamera
from editor.code.files import CodeFiles
from editor.commands.command import VIEW_TABLE
from editor.document import Document
from editor.host import Host
from editor.journal import Journal, Recovery
from editor.messages import Messages
from editor.opening import OpenJob
from editor.playback import Playback
from editor.preferences import Preferences
from editor.preview import Preview
from editor.selecting import nodes_in_box
from editor.tables import SettingsTable
from editor.thumbnails import Thumbnails
from editor.tools import Tools
from editor.viewport_image import ViewportImage
from editor.watch import ShaderWatch
from editor.work import ForcedCost, Work
from engine.core.errors import LucarnaError
from engine.core.param import ParamBlock

if TYPE_CHECKING:
    from engine.app.feature_pixels import FeatureEffect


@dataclass(frozen=True, slots=True)
class ChooseFile:
    """A file to choose: `endings` in small letters, `start` a folder or the last file, `take` gets the path."""

    title: str
    endings: tuple[str, ...]
    start: Path
    take: Callable[[Path], None]


@dataclass(slots=True)
class UiRequests:
    """What operations ask of the window, which carries it out and clears it."""

    palette: bool = False
    open_dialog: bool = False
    save_dialog: bool = False
    choose: ChooseFile | None = None
    welcome: bool = False
    help: bool = False
    about: bool = False
    reset_layout: bool = False
    quit: bool = False
    focus_panel: str = ""
    toggle_panel: str = ""
    error_bar: str = ""
    notice: str = ""
    #: what to do once the user has said what becomes of unsaved changes
    after_discard: Callable[[], None] | None = None
    status_hint: str = ""
    scale_changed: bool = False
    #: sessions that died with unsaved edits, to ask about
    recoveries: list[Recovery] = field(default_factory=list)
    #: node row whose name the tree should edit, or -1
    rename: int = -1
    #: rows under the pointer to choose from
    pick_list: tuple[int, ...] = ()
    copy_text: str = ""
    #: takes the clipboard's text
    paste: Callable[[str], None] | None = None
    #: the file that is being dragged out of the assets panel
    dragged: Path | None = None
    #: a texel to show in the texture viewer (numbers.PixelRequest), or None
    show_pixel: Any = None


@dataclass(slots=True)
class Session:
    """`device` is set by the window once it has a context. `width`, `height`: the viewport in pixels."""

    host: Host
    preferences: Preferences = field(default_factory=Preferences)
    device: Any = None
    messages: Messages = field(default_factory=Messages)
    document: Document | None = None
    job: OpenJob | None = None
    camera: OrbitCamera = field(default_factory=OrbitCamera)
    playback: Playback = field(default_factory=Playback)
    image: ViewportImage = field(default_factory=ViewportImage)
    thumbnails: Thumbnails = field(default_factory=Thumbnails)
    preview: Preview = field(default_factory=Preview)
    asset_pictures: AssetThumbnails = field(default_factory=AssetThumbnails)
    ui: UiRequests = field(default_factory=UiRequests)
    code: CodeFiles = field(default_factory=CodeFiles)
    shaders: ShaderWatch = field(default_factory=ShaderWatch)
    width: int = 1280
    height: int = 720
    save_preferences: bool = True
    #: the user is dragging something, or time runs: pictures should come soon rather than sharp
    interacting: bool = False
    tools: Tools = field(default_factory=Tools)
    #: where edits are journalled; None: nowhere
    recovery_folder: Path | None = None
    journal: Journal | None = None
    #: name of a node to select when a document opens
    select_on_open: str = ""
    #: the last thing the user asked for that could not be done
    failure: LucarnaError | None = None
    #: something long that is done in steps, and what the last frame would cost with nothing left out
    work: Work | None = None
    forced_cost: ForcedCost | None = None
    #: what features of the scene's variants change, where it was measured
    feature_effects: list[FeatureEffect] | None = None
    #: results of experiments (engine.report.records.Result) by name, of this document
    reports: dict[str, Any] = field(default_factory=dict)
    #: the render settings that each was measured with
    report_settings: dict[str, dict[str, Any]] = field(default_factory=dict)
    #: what panels and overlays of animation show
    animating: AnimatingView = field(default_factory=AnimatingView)
    #: what the clock was last set up for, see animating.following
    followed: Any = None
    #: the renderer's findings, of skins and of lights, that are in the log
    drawing_noted: tuple[Any, Any] = (None, None)
    _settings: ParamBlock | None = None

    # --- opening ---

    def open(self, path: Path) -> None:
        """Start to open a project, folder, source or scene; asks first when there are unsaved changes."""
        if self.document is not None and self.document.dirty:
            self.ui.after_discard = lambda: self._start(path)
            return
        self._start(path)

    def poll(self) -> None:
        """Once a frame: take over what a finished job found, and files that were edited. The present document stays
        until the next one is good."""
        self.shaders.poll(self)
        self.asset_pictures.pump(self)
        work.step(self)
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

    def adopt(self, document: Document) -> None:
        """Make `document` the open one, close the one before, look at it; the camera stays when it is the same file."""
        again = self.document is not None and self.document.source == document.source
        self.close()
        self.document = document
        document.tables[VIEW_TABLE] = SettingsTable(lambda: self.settings)
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
        self.playback.playing = self.playback.available and not self.software
        document.runtime.update(0.0)
        if not again:
            self.reset_camera()
        if self.select_on_open in scene.nodes.name:
            document.select(list(scene.nodes.name).index(self.select_on_open))
        self.preferences.add_recent(document.source)
        self.remember()
        recovering.start(self, document)

    def close(self) -> None:
        """Close the open document, if any, without asking."""
        if self.document is not None:
            if self.journal is not None:
                self.journal.finish()
                self.journal = None
            if self.work is not None:
                self.work.close()
            self.work = self.forced_cost = self.feature_effects = None
            self.reports.clear()
            self.tools.forget()
            self.image.forget()
            with self.device_frame():
                self.thumbnails.forget()
                self.preview.forget()
                self.document.close()
            self.document = None
            self.playback = Playback()

    def fail(self, error: LucarnaError) -> None:
        """Log an error and show it in the bar; nothing else changes."""
        self.messages.error(error)
        self.ui.error_bar = str(error)
        self.failure = error

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

    def end_gesture(self) -> None:
        if self.document is not None:
            self.document.history.end_gesture()

    def undo(self) -> None:
        command = self.document.history.undo() if self.document is not None else None
        if command is not None:
            self.ui.notice = f"Undone: {command.describe()}"
            following.follow(self)

    def redo(self) -> None:
        command = self.document.history.redo() if self.document is not None else None
        if command is not None:
            self.ui.notice = f"Redone: {command.describe()}"
            following.follow(self)

    def thumbnail(self, material: int, slot: str) -> int:
        """The native id of a small picture of the texture in a material's slot; 0 where there is none."""
        if self.document is None or self.null_pictures:
            return 0
        texture, layer = self.document.runtime.residency.materials.slot_texture(material, slot)
        with self.device_frame():
            return self.thumbnails.get(self.device, texture, layer)

    @property
    def null_pictures(self) -> bool:
        """Whether the device makes no pictures that a window could show."""
        return self.device is None or self.device.caps.backend == "null"

    def set_visible(self, rows: Sequence[int], visible: bool) -> None:
        verb = "Show" if visible else "Hide"
        what = self.node_name(rows[0]) if len(rows) == 1 else f"{len(rows)} nodes"
        self.edit("nodes", "visible", rows, [visible] * len(rows), label=f"{verb} {what}")

    def node_name(self, row: int) -> str:
        if self.document is None or row < 0:
            return ""
        return str(self.document.runtime.scene.nodes.name[row]) or f"node {row}"

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

    # --- looking ---

    @property
    def settings(self) -> ParamBlock:
        """The render settings of the viewport; view state, not part of the document."""
        if self._settings is None:
            self._settings = self._fresh_settings()
        return self._settings

    def reset_settings(self) -> None:
        self._settings = self._fresh_settings()

    def _fresh_settings(self) -> ParamBlock:
        settings = self.host.new_settings()
        if self.software and any(p.name == "samples" for p in settings.PARAMS):
            settings.samples = 1  # a software rasteriser pays for each one in full
            settings.anisotropy = 1.0
        return settings

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

    @property
    def software(self) -> bool:
        """Whether pictures are made by the CPU, and so are slow."""
        return self.device is not None and bool(self.device.caps.software)

    @property
    def aspect(self) -> float:
        return self.width / max(self.height, 1)

    def view(self) -> Any:
        return self.host.view(self.camera, self.width, self.height, self.settings)

    def reset_camera(self) -> None:
        """The scene's own camera, or one that frames it."""
        if self.document is None:
            return
        camera = self.document.runtime.default_camera(self.aspect)
        matrix = np.asarray(camera.world_from_camera, dtype=np.float64)
        low, high = self.document.bounds()
        distance = 5.0
        if np.isfinite(low).all() and np.isfinite(high).all():
            ahead = float((matrix[:3, 3] - 0.5 * (low + high)) @ matrix[:3, 2])
            distance = max(ahead, 0.1 * float(np.linalg.norm(high - low)), 1e-3)
        self.camera = camera_controls.from_matrix(matrix, distance, float(camera.yfov))

    def frame_selection(self) -> None:
        """Look at the selected nodes, or at everything."""
        if self.document is None:
            return
        low, high = self.document.bounds(self.document.selection)
        if not self.document.selection or not np.isfinite(low).all():
            self.frame_all()
            return
        if float(np.linalg.norm(high - low)) <= 0.0:  # a light or an empty: something of a metre round it
            low, high = low - 0.5, high + 0.5
        self.camera = camera_controls.frame(self.camera, low, high, self.aspect)

    def frame_all(self) -> None:
        if self.document is not None:
            self.camera = camera_controls.frame(self.camera, *self.document.bounds(), self.aspect)

    def pick(self, u: float, v: float, *, toggle: bool = False) -> int:
        """Select what shows at (u, v) of the viewport, 0..1 from its top left; returns the node row, or -1."""
        if self.document is None or self.image.frame is None:
            return -1
        try:
            row = int(self.document.runtime.pick(self.view(), u * self.width, v * self.height))
        except LucarnaError as error:
            self.messages.error(error)
            return -1
        if row in self.document.locked:
            row = next((r for r, _point in self.hits(u, v) if r not in self.document.locked), -1)
        self.document.select(row, toggle=toggle)
        return row

    def hits(self, u: float, v: float) -> list[tuple[int, NDArray[np.float64]]]:
        """Every node under (u, v) with the point (world) where it is hit, the nearest first."""
        if self.document is None or self.image.frame is None:
            return []
        try:
            return self.document.runtime.pick_hits(self.view(), u * self.width, v * self.height)
        except LucarnaError as error:
            self.messages.error(error)
            return []

    def pick_through(self, u: float, v: float) -> None:
        """Let the user choose among all that lies under (u, v)."""
        self.ui.pick_list = tuple(row for row, _point in self.hits(u, v))

    def measure(self, u: float, v: float) -> None:
        """Take the point under (u, v) as the next end of the measure."""
        found = self.hits(u, v)
        if not found:
            self.ui.notice = "Nothing there to measure"
            return
        self.tools.measure(found[0][1])

    def select_box(self, low: tuple[float, float], high: tuple[float, float], *, add: bool = False) -> None:
        """Select every drawn node whose middle lies in the rectangle (u, v) .. (u, v); lights and cameras too."""
        document = self.document
        if document is None:
            return
        rows = nodes_in_box(document, self.camera, low, high, self.aspect)
        kept = document.selection if add else ()
        document.selection = tuple(dict.fromkeys((*kept, *rows)))

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

    def visible_state(self) -> tuple[Hashable, ...]:
        """What the viewport's picture depends on, besides its size: equal states give equal pictures."""
        document = self.document
        if document is None:
            return ()
        scene = document.runtime.scene
        return (
            self.camera,
            self.settings.key(),
            document.history.revision,
            int(scene.structure_rev),
            int(scene.transform_rev),
            int(getattr(document.runtime.residency, "structure_rev", 0)),
            self.playback.time,
            self.playback.elapsed if self.playback.playing else 0.0,
        )

    # --- the rest ---

    def request_quit(self) -> bool:
        """True when the window may close now; else the user is asked first."""
        if self.unsaved and not self.ui.quit:
            self.ui.after_discard = self._quit
            return False
        return True

    @property
    def unsaved(self) -> list[str]:
        """Names of what has unsaved changes: the scene, texts."""
        scene = [self.document.name] if self.document is not None and self.document.dirty else []
        return scene + [text.name for text in self.code.dirty]

    def save_all(self) -> bool:
        """Save the scene and all texts; False when something could not be, or must be asked first."""
        for text in self.code.dirty:
            self.code.front = text
            self.code.raise_tab = True
            if not self.save_code():
                return False
        return self.document is None or not self.document.dirty or self.save()

    def remember(self) -> None:
        """Write the preferences; a failure is a warning in the log."""
        if self.save_preferences:
            problem = preferences.save(self.preferences)
            if problem:
                self.messages.warn(f"Preferences were not saved: {problem}")

    def _quit(self) -> None:
        self.ui.quit = True

    @contextmanager
    def device_frame(self) -> Iterator[None]:
        """Between the window library's own drawing: the device sets its state up, and hands the library's back."""
        self.device.begin_frame()
        try:
            yield
        finally:
            self.device.end_frame()

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
