"""CodeDocument: a text file that is edited here, and perhaps elsewhere too; nothing is ever overwritten unseen."""

from __future__ import annotations

from codecs import BOM_UTF8
from pathlib import Path

from editor.code.line_ends import join_ends, split_ends
from engine.core.atomic import write_bytes
from engine.core.errors import InputError, OutputError
from engine.core.watched import Stamp, stamp

#: a shader is small; above, it is some other file
MAX_BYTES = 4 << 20


class CodeDocument:
    """`text`: what is being edited, with \\n line ends. `saved`: what the file holds as far as we know.

    `theirs`: the file's content when it was changed elsewhere while there were unsaved changes here, else None.
    `revision` grows when `text` was replaced by something else than typing. What is written has the line ends and the
    byte order mark that the file had.
    """

    def __init__(self, path: Path, *, read_only: bool = False) -> None:
        self.path = path
        self.read_only = read_only
        self.text = self.saved = ""
        self.theirs: str | None = None
        self.gone = False
        self.revision = 0
        self._bom = False
        #: the text as the file last held it, and the ends of its lines
        self._read_as: tuple[str, list[str]] = ("", [])
        self._stamp: Stamp = None
        self.text = self.saved = self._read()

    @property
    def name(self) -> str:
        return self.path.name

    @property
    def dirty(self) -> bool:
        return self.text != self.saved

    @property
    def conflict(self) -> bool:
        """Changed here and elsewhere: the user must say which."""
        return self.theirs is not None

    @property
    def language(self) -> str:
        known = {".toml": "toml", ".json": "json", ".md": "markdown", ".txt": "text"}
        return known.get(self.path.suffix.lower(), "glsl")

    def edit(self, text: str) -> None:
        """Take over what was typed."""
        if not self.read_only:
            self.text = text

    def put(self, text: str) -> None:
        """Replace the text from outside the text field (undoable there)."""
        if not self.read_only and text != self.text:
            self.text = text
            self.revision += 1

    def save(self) -> bool:
        """Write the file, atomically; False when there is a conflict or nothing to do. Raises OutputError."""
        self.look()
        if self.read_only:
            raise OutputError("is read-only here", where=self.path, hint="copy it into the project to edit it")
        if self.conflict or not (self.dirty or self.gone):
            return False
        data = join_ends(self.text, *self._read_as)
        write_bytes(self.path, data.encode("utf-8-sig" if self._bom else "utf-8"))
        self._read_as = split_ends(data)
        self._stamp, self.saved, self.gone = stamp(self.path), self.text, False
        return True

    def look(self) -> bool:
        """See whether the file was changed elsewhere. Without unsaved changes here its text is taken over; with some it
        is a conflict. True when anything became known."""
        now = stamp(self.path)
        if now == self._stamp:
            return False
        if now is None:
            self._stamp, self.gone = None, True
            return True
        try:
            text = self._read()
        except InputError:
            return False  # half written, perhaps: look again
        self.gone = False
        if text in (self.saved, self.text):
            self.saved, self.theirs = text, None
        elif self.dirty:
            self.theirs = text
        else:
            self.saved = self.text = text
            self.revision += 1
        return True

    def keep_mine(self) -> None:
        """End a conflict: the next save replaces what the file holds."""
        if self.theirs is not None:
            self.saved, self.theirs = self.theirs, None

    def take_theirs(self) -> None:
        """End a conflict: what was typed here goes (the text field's undo brings it back)."""
        if self.theirs is not None:
            self.text = self.saved = self.theirs
            self.theirs = None
            self.revision += 1

    def _read(self) -> str:
        """The file's text with \\n line ends. Raises InputError."""
        seen = stamp(self.path)
        try:
            if seen is not None and seen[1] > MAX_BYTES:
                raise InputError(f"is larger than {MAX_BYTES >> 20} MiB", where=self.path, hint="this is no shader")
            data = self.path.read_bytes()
            text = data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise InputError(f"is not UTF-8 text: {error.reason} at byte {error.start}", where=self.path) from error
        except OSError as error:
            raise InputError(f"cannot be read: {error.strerror or error}", where=self.path) from error
        self._stamp = seen
        self._bom = data.startswith(BOM_UTF8)
        self._read_as = split_ends(text)
        return self._read_as[0]
