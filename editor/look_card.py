"""The look card in the viewport's corner: when it is drawn anew, and its texture. No imgui."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import astuple
from typing import TYPE_CHECKING, Any

from editor.baking import surroundings_revision
from editor.viewport_image import PATIENCE
from engine.core.errors import LucarnaError

if TYPE_CHECKING:
    from editor.session import Session


class LookCardPicture:
    """`waiting`: shader programs are being made."""

    def __init__(self) -> None:
        self.waiting = False
        self._card: Any = None
        self._owner: object = None
        self._key: Hashable = None
        self._native = 0

    def native(self, session: Session, width: int, height: int) -> int:
        """The texture of the card as the viewport's camera sees it, that many pixels; 0 where there is none (yet)."""
        document = session.document
        if document is None or session.null_pictures or width < 8 or height < 8:
            return 0
        runtime, scene = document.runtime, document.runtime.scene
        camera = session.camera
        key = (
            id(runtime), width, height, camera.yaw, camera.pitch, camera.roll, session.settings.key(),
            astuple(scene.environment), astuple(scene.look), surroundings_revision(runtime),
        )  # fmt: skip
        if key == self._key:
            return self._native
        try:
            with session.device_frame():
                if self._owner is not runtime:
                    self._make(runtime)
                frame = self._card.render(camera.rotation(), session.settings, width, height, PATIENCE)
        except LucarnaError as error:
            session.messages.error(error)
            session.preferences.show_look_card = False
            return 0
        self.waiting = frame is None
        if frame is not None:
            self._key, self._native = key, int(frame.color.native)
        return self._native

    def forget(self) -> None:
        """Inside a device frame, before the document's runtime closes."""
        if self._card is not None:
            self._card.release()
        self._card, self._owner, self._key, self._native, self.waiting = None, None, None, 0, False

    def _make(self, runtime: Any) -> None:
        from engine.app.look_card import LookCard

        self.forget()
        self._card, self._owner = LookCard(runtime), runtime
