"""What every panel is handed: the session, the operations, the fonts. Lives as long as the window."""

from __future__ import annotations

from dataclasses import dataclass, field

from editor.idling import NEVER
from editor.keymap import Keymap
from editor.operations import Operation, Operations
from editor.plugins.manager import PluginManager
from editor.session import Session
from editor.theme import Fonts


@dataclass(slots=True)
class Ui:
    """`pixel_scale`: framebuffer pixels per imgui unit. `drawn`: frames drawn so far."""

    session: Session
    operations: Operations
    fonts: Fonts = field(default_factory=Fonts)
    pixel_scale: float = 1.0
    drawn: int = 0
    #: in which frame the viewport was last drawn
    viewport_at: int = -1
    #: where its picture is in the window: x, y, width, height, imgui units
    viewport_area: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    #: an operation that was chosen and wants to be told something (see dialogs.arguments)
    asked: Operation | None = None
    #: whether the keys steer the camera
    flying: bool = False
    #: seconds after which somebody wants another frame, though nothing happens; see again_in
    asked_for: float = NEVER
    plugins: PluginManager | None = None
    keymap: Keymap = field(init=False)

    def __post_init__(self) -> None:
        self.keymap = Keymap(self.operations, self.session.preferences)

    def again_in(self, seconds: float) -> None:
        """Said while drawing: another frame after so many seconds, 0 for the next one. The window draws nothing while
        nothing happens, so what moves by itself says this in every frame."""
        self.asked_for = min(self.asked_for, seconds)

    def keep_live(self) -> None:
        """Where the viewport lies behind another panel: make its picture, if anything in it changed."""
        image = self.session.image
        if self.viewport_at < self.drawn - 1 and image.width:
            image.update(self.session, image.width, image.height)
