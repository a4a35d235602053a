"""SessionState: what a session holds, as fields, and what follows from them alone. No imgui, no GL."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from editor import preferences
from editor.animating.view import AnimatingView
from editor.asset_links import AssetLinks
from editor.asset_thumbnails import AssetThumbnails
from editor.camera_controls import OrbitCamera
from editor.code.files import CodeFiles
from editor.comparing.comparing import Comparing
from editor.document import Document
from editor.history_pictures import HistoryPictures
from editor.host import Host
from editor.journal import Journal
from editor.look_card import LookCardPicture
from editor.messages import Messages
from editor.opening import OpenJob
from editor.playback import Playback
from editor.preferences import Preferences
from editor.preview import Preview
from editor.reimporting import ImportJob, SourceWatch
from editor.requests import UiRequests
from editor.tabs import Tab
from editor.thumbnails import Thumbnails
from editor.tools import Tools
from editor.viewport_image import ViewportImage
from editor.watch import ShaderWatch
from editor.work import ForcedCost, Work
from engine.core.errors import LucarnaError
from engine.core.param import ParamBlock

if TYPE_CHECKING:
    from engine.app.feature_pixels import FeatureEffect


@dataclass(slots=True)
class SessionState:
    """`device` is set by the window once it has a context. `width`, `height`: the viewport in pixels."""

    host: Host
    preferences: Preferences = field(default_factory=Preferences)
    device: Any = None
    messages: Messages = field(default_factory=Messages)
    #: the document in front; the others wait in `tabs`
    document: Document | None = None
    tabs: list[Tab] = field(default_factory=list)
    job: OpenJob | None = None
    #: dropped files that wait to be opened
    queue: list[Path] = field(default_factory=list)
    camera: OrbitCamera = field(default_factory=OrbitCamera)
    playback: Playback = field(default_factory=Playback)
    image: ViewportImage = field(default_factory=ViewportImage)
    thumbnails: Thumbnails = field(default_factory=Thumbnails)
    history_pictures: HistoryPictures = field(default_factory=HistoryPictures)
    preview: Preview = field(default_factory=Preview)
    comparing: Comparing = field(default_factory=Comparing)
    look_card: LookCardPicture = field(default_factory=LookCardPicture)
    asset_pictures: AssetThumbnails = field(default_factory=AssetThumbnails)
    #: which file of the project names which
    links: AssetLinks = field(default_factory=AssetLinks)
    #: the file that is chosen in the assets panel
    asset: Path | None = None
    ui: UiRequests = field(default_factory=UiRequests)
    code: CodeFiles = field(default_factory=CodeFiles)
    shaders: ShaderWatch = field(default_factory=ShaderWatch)
    #: the source of the document in front, and another import of it that is being made
    sources: SourceWatch = field(default_factory=SourceWatch)
    importing: ImportJob | None = None
    width: int = 1280
    height: int = 720
    save_preferences: bool = True
    #: the user is dragging something, or time runs: pictures should come soon rather than sharp
    interacting: bool = False
    #: of that: the user drags something or turns the wheel
    handling: bool = False
    tools: Tools = field(default_factory=Tools)
    #: where edits are journalled; None: nowhere
    recovery_folder: Path | None = None
    journal: Journal | None = None
    #: name of a node to select when a document opens
    select_on_open: str = ""
    #: the next document plays from its first picture on, however slowly pictures are made
    show_off: bool = False
    #: when to look at the files of prefabs again
    prefabs_at: float = 0.0
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

    @property
    def null_pictures(self) -> bool:
        """Whether the device makes no pictures that a window could show."""
        return self.device is None or self.device.caps.backend == "null"

    @property
    def software(self) -> bool:
        """Whether pictures are made by the CPU, and so are slow."""
        return self.device is not None and bool(self.device.caps.software)

    @property
    def aspect(self) -> float:
        return self.width / max(self.height, 1)

    def node_name(self, row: int) -> str:
        if self.document is None or row < 0:
            return ""
        return str(self.document.runtime.scene.nodes.name[row]) or f"node {row}"

    def fail(self, error: LucarnaError) -> None:
        """Log an error and show it in the bar; nothing else changes."""
        self.messages.error(error)
        self.ui.error_bar = str(error)
        self.failure = error

    def remember(self) -> None:
        """Write the preferences; a failure is a warning in the log."""
        if self.save_preferences:
            problem = preferences.save(self.preferences)
            if problem:
                self.messages.warn(f"Preferences were not saved: {problem}")

    @contextmanager
    def device_frame(self) -> Iterator[None]:
        """Between the window library's own drawing: the device sets its state up, and hands the library's back."""
        self.device.begin_frame()
        try:
            yield
        finally:
            self.device.end_frame()
