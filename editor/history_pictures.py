"""Small pictures of the viewport as each entry of the history left it. No imgui.

    ViewportImage.update ─► take: the frame that was drawn anyway ─► one small draw on the device ─► the history panel

Nothing is read back and nothing is rendered for it: a state that never was on the screen, as those that a recovered
session did again, has a picture from when undo or redo shows it. In a gesture none is taken, after it one.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Collection, Hashable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from engine.core.errors import LucarnaError
from engine.core.paths import shaders_dir
from engine.gpu.types import Bindings, ColorAttachment, RasterState, RenderPipelineDesc, SamplerDesc, TextureDesc

if TYPE_CHECKING:
    from editor.commands.command import Edit
    from editor.document import Document
    from editor.session import Session

#: pixels that a picture has at most, and how many there are: 20 MiB in all
WIDTH, HEIGHT, LIMIT = 256, 160, 128
_UNIT = 10

#: (id of the document, id of the entry; 0: as it was opened)
Key = tuple[int, int]


@dataclass(slots=True)
class _Picture:
    """`entry` is kept so that its id stays its own. `camera`: that it was taken by; None: it is as it stays."""

    document: Document
    entry: Edit | None
    texture: Any
    camera: Hashable | None


class HistoryPictures:
    """The pictures of all open documents, the least recently shown go first."""

    def __init__(self) -> None:
        self._made: OrderedDict[Key, _Picture] = OrderedDict()
        self._drawn_by: tuple[Any, Any, Any] | None = None  # device, pipeline, sampler
        self._seen: Hashable = None
        self.off = False

    def __len__(self) -> int:
        return len(self._made)

    def native(self, document: Document, entry: Edit | None) -> tuple[int, float]:
        """Native id of the picture after `entry` (None: as opened) and its height over its width; (0, 0) for none."""
        key = (id(document), id(entry) if entry is not None else 0)
        found = self._made.get(key)
        if found is None:
            return 0, 0.0
        self._made.move_to_end(key)
        return int(found.texture.native), found.texture.desc.height / found.texture.desc.width

    def take(self, session: Session, frame: Any, *, resting: bool) -> None:
        """Picture the state at hand, where `frame` shows it and it has no picture; again once it is `resting`, since
        the first frames after an edit may be coarse. Costs a comparison where there is nothing to do."""
        document = session.document
        if document is None or frame is None or self.off or session.null_pictures:
            return
        history = document.history
        if history.in_gesture or history.visited or not session.preferences.history_pictures:
            return
        entry = history.last
        key = (id(document), id(entry) if entry is not None else 0)
        if (key, resting) == self._seen:
            return
        self._seen = (key, resting)
        made = self._made.get(key)
        if made is not None and (made.camera is None or not resting):
            return
        if made is not None and made.camera != session.camera:
            made.camera = None
            return
        try:
            with session.device_frame():
                texture = self._draw(session.device, frame.color)
        except LucarnaError as error:  # pictures less, and the editor goes on
            self.off = True
            session.messages.warn(f"The history shows no pictures: {error}")
            return
        if made is not None:
            made.texture.release()
        self._made[key] = _Picture(document, entry, texture, None if resting else session.camera)
        self._made.move_to_end(key)
        self._prune(document)

    def forget(self, document: Document | None = None) -> None:
        """Drop the pictures of a document that is closed, or all. Inside a device frame."""
        for key in [k for k, made in self._made.items() if document is None or made.document is document]:
            self._made.pop(key).texture.release()
        self._seen = None

    def _prune(self, document: Document) -> None:
        """Without those whose entries the history forgot, and the oldest beyond the limit."""
        entries = document.history.entries, document.history.undone
        alive: Collection[int] = {0, *(id(e) for side in entries for e in side)}
        for key, made in list(self._made.items()):
            if made.document is document and key[1] not in alive:
                self._made.pop(key).texture.release()
        while len(self._made) > LIMIT:
            self._made.popitem(last=False)[1].texture.release()

    def _draw(self, device: Any, source: Any) -> Any:
        scale = min(WIDTH / source.desc.width, HEIGHT / source.desc.height, 1.0)
        width, height = (max(round(n * scale), 1) for n in (source.desc.width, source.desc.height))
        _, pipeline, sampler = self._tools(device)
        target = device.texture(TextureDesc("rgba8", width, height, label="history picture"))
        with device.render_pass("history picture", [ColorAttachment(target, clear=(0.0, 0.0, 0.0, 1.0))]) as draw:
            draw.set_pipeline(pipeline)
            draw.set_bindings(Bindings(textures={_UNIT: (source, sampler)}))
            draw.draw(3)
        return target

    def _tools(self, device: Any) -> tuple[Any, Any, Any]:
        if self._drawn_by is None or self._drawn_by[0] is not device:
            from engine.gpu.preprocess import flatten

            root = shaders_dir()
            pipeline = device.render_pipeline(
                RenderPipelineDesc(
                    "history picture",
                    flatten(root / "passes/fullscreen.vert", "vertex", search=[root]),
                    flatten(root / "editor/small_picture.frag", "fragment", search=[root]),
                    depth=None,
                    raster=RasterState("none"),
                )
            )
            self._drawn_by = device, pipeline, device.sampler(SamplerDesc("clamp", "clamp", min_filter="linear"))
        return self._drawn_by
