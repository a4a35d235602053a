"""Comparing: state A of the view, how it is shown beside the present one, B, and how the two differ. No imgui."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from editor.comparing.moment import Moment, before_last_edit, now
from editor.comparing.numbers import FlipAside
from engine.core.errors import LucarnaError
from engine.report.picture_difference import PictureDifference, difference_map, picture_difference

if TYPE_CHECKING:
    from editor.document import Document
    from editor.session import Session

#: what the viewport shows: B alone; A left of the wipe; A alone; where they differ
OFF, WIPE, ONLY_A, DIFFERENCE = "off", "wipe", "a", "difference"
#: pictures of the viewport whose times are kept: their median is what B costs
TIMES = 9


class Comparing:
    """`a`, `mode` and `split` (where the wipe is, 0..1) are those of the document last in front; each document has its
    own. `held`: A shows while a key is held down."""

    def __init__(self) -> None:
        self.a: Moment | None = None
        self.mode = OFF
        self.split = 0.5
        self.held = False
        self.difference: PictureDifference | None = None
        self.flip: float | str | None = None
        self.aside = FlipAside()
        self._document: Document | None = None
        #: by id: (document, A, mode, split) of those that are not in front
        self._behind: dict[int, tuple[Document, Moment, str, float]] = {}
        self._held_moment: Moment | None = None
        self._texture: Any = None
        self._uploaded: Any = None
        self._compared: tuple[object, ...] = ()
        self._map: Any = None
        #: times of both in turn (see measuring), where they were measured
        self.measured: tuple[list[float], list[float]] | None = None
        self._b_times: list[float] = []
        self._b_renders = -1

    # --- what a user does ---

    def take(self, session: Session, label: str = "") -> None:
        """Make the present state A."""
        self._follow(session)
        self.a = now(session, label or self._name(session))
        self._forget_numbers()

    def show(self, session: Session, mode: str) -> None:
        """Show the two that way, or B alone where they show so already. Takes the present state where there is no A."""
        if self.moment(session) is None:
            self.take(session)
        self.mode = OFF if self.mode == mode else mode
        self.changed()

    def go_back(self, session: Session) -> None:
        """Make A the present state, and the present one A: the undo history goes there, redo leads on."""
        a, document = self.moment(session), session.document
        if a is None or document is None:
            return
        place = a.place(document)
        if place < 0:
            session.ui.notice = f"{a.label}: later edits have cut that branch of the history off"
            return
        b = now(session, self._name(session))
        session.go_to(place)
        if len(document.history.entries) != place:
            return
        for name, value in a.settings.items():
            if getattr(session.settings, name) != value:
                setattr(session.settings, name, value)
        self.a = b
        self._forget_numbers()

    def clear(self) -> None:
        self.a, self.mode = None, OFF
        self._forget_numbers()

    def hold(self, session: Session) -> None:
        """Show A until `release`; where none was taken, the state before the last edit."""
        self.held = True
        self._held_moment = self.moment(session) or before_last_edit(session)
        if self._held_moment is None:
            self.held = False
            session.ui.notice = "Nothing to compare with: take a state first, or edit something"

    def release(self) -> None:
        self.held, self._held_moment = False, None

    # --- what is shown ---

    def moment(self, session: Session) -> Moment | None:
        """A of the document in front."""
        self._follow(session)
        return self.a if session.document is not None else None

    def parked(self, session: Session) -> Callable[[], None]:
        """The document in front goes behind: call this before `forget`, and what it returns after, so that A waits."""
        self._follow(session)
        document, kept = self._document, self.a
        if document is None or kept is None:
            return lambda: None
        state = (document, kept, self.mode, self.split)
        return lambda: self._behind.update({id(document): state})

    def _follow(self, session: Session) -> None:
        """Another document came to the front: its own A is the one now."""
        front = session.document
        if front is self._document:
            return
        self.release()
        self.a, self.mode, self._document = None, OFF, front
        if front is not None and id(front) in self._behind:
            _, self.a, self.mode, self.split = self._behind.pop(id(front))
        self._forget_numbers()

    def showing(self, session: Session) -> str:
        """How the viewport shows the two now: one of the modes."""
        if self.held and self._held_moment is not None:
            return ONLY_A
        return self.mode if self.moment(session) is not None else OFF

    def shown_moment(self, session: Session) -> Moment | None:
        return self._held_moment if self.held else self.moment(session)

    def update(self, session: Session, width: int, height: int) -> None:
        """Before the viewport's own picture is made: render A where it would differ. A failure ends the comparison."""
        mode, a = self.showing(session), self.shown_moment(session)
        if mode == OFF or a is None:
            return
        try:
            if a.update(session, width, height):
                session.image.invalidate()  # it was made with the same renderer: what is there may be A's by now
        except LucarnaError as error:
            session.messages.error(error)
            session.ui.notice = f"{a.label} cannot be shown: {error}"
            self.release()
            self.mode = OFF

    def after(self, session: Session) -> None:
        """After the viewport's own picture was made: what the two differ by, unless something moves."""
        image, a = session.image, self.shown_moment(session)
        if self.showing(session) == OFF or a is None or image.frame is None or a.pixels is None:
            return
        if image.renders != self._b_renders:
            self._b_renders = image.renders
            self._b_times = [*self._b_times, float(image.frame.stats.total_ms)][-TIMES:]
        about = (id(a), a.revision, image.renders)
        if self.aside.answer is not None and self.aside.answer[0] == about:
            self.flip = self.aside.answer[1]
        if about == self._compared or session.interacting or self.held:
            return
        self._compared = about
        b = np.array(image.pixels(), np.uint8)
        self.difference, self.flip, self._map = None, None, None
        if b.shape != a.pixels.shape:  # A's last picture is of another size
            return
        self.difference = picture_difference(a.pixels, b)
        if self.mode == DIFFERENCE:
            self._map = difference_map(a.pixels, b)
        if self.difference.equal:
            self.flip = 0.0
        else:
            self.aside.ask(about, a.pixels, b)

    @property
    def waiting(self) -> bool:
        """FLIP is being found: the window should look again soon."""
        return self.difference is not None and self.flip is None

    def times(self) -> tuple[float, float]:
        """Median milliseconds of A and B: as they were measured in turn, else of the last pictures; 0 for none."""
        if self.measured is not None:
            return statistics.median(self.measured[0]), statistics.median(self.measured[1])
        a = self.a.times if self.a is not None else []
        return (statistics.median(a) if a else 0.0, statistics.median(self._b_times) if self._b_times else 0.0)

    def native(self, session: Session) -> int:
        """The id of a texture with A's picture, or with the map of differences; 0 where there is none."""
        a = self.shown_moment(session)
        mode = self.showing(session)
        pixels = self._map if mode == DIFFERENCE else None if a is None else a.pixels
        if pixels is None or session.null_pictures:
            return 0
        if pixels is not self._uploaded:
            self._upload(session, pixels)
            self._uploaded = pixels
        return int(self._texture.native)

    def _upload(self, session: Session, pixels: Any) -> None:
        from engine.gpu.types import TextureDesc

        height, width = pixels.shape[:2]
        rgba = np.full((height, width, 4), 255, np.uint8)
        rgba[:, :, :3] = pixels[:, :, :3]
        with session.device_frame():
            if self._texture is None or (self._texture.desc.width, self._texture.desc.height) != (width, height):
                self._release_texture()
                self._texture = session.device.texture(TextureDesc("rgba8", width, height, label="compare"))
            self._texture.write(rgba)

    def forget(self, session: Session) -> None:
        """A document is being closed: nothing of A stays, if it is of that one."""
        self._follow(session)
        self.release()
        self.clear()
        self._document = None
        if self._texture is not None:
            with session.device_frame():
                self._release_texture()

    def changed(self) -> None:
        """Another way to show the two was chosen: the numbers, and what they are drawn from, are found again."""
        self._compared = ()

    def _release_texture(self) -> None:
        if self._texture is not None:
            self._texture.release()
        self._texture, self._uploaded = None, None

    def _forget_numbers(self) -> None:
        self.difference, self.flip, self._map, self.measured = None, None, None, None
        self._compared, self._b_times = (), []

    def _name(self, session: Session) -> str:
        document = session.document
        assert document is not None
        count = len(document.history.entries)
        return f"{count}. {document.history.undo_label}" if count else "As opened"
