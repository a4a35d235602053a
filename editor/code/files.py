"""CodeFiles: the text files that are open, and which one is in front."""

from __future__ import annotations

import os
from pathlib import Path

from editor.code.document import CodeDocument
from engine.core.atomic import write_bytes
from engine.core.errors import InputError
from engine.core.paths import data_root, shaders_dir


class CodeFiles:
    """`cursor`: (line, column) from 1 to go to in the document in front, or None. `focused`: its text has the keys."""

    def __init__(self) -> None:
        self.documents: list[CodeDocument] = []
        self.front: CodeDocument | None = None
        self.cursor: tuple[int, int] | None = None
        self.focused = False
        #: open the search over the text in front
        self.find = False
        #: bring the front document's tab forward
        self.raise_tab = False

    def open(self, path: Path, line: int = 0, column: int = 0) -> CodeDocument:
        """The document of `path`, opened once, put in front with the cursor at (line, column). Raises InputError."""
        path = path.resolve()
        document = next((d for d in self.documents if d.path == path), None)
        if document is None:
            document = CodeDocument(path, read_only=is_read_only(path))
            self.documents.append(document)
        self.front, self.raise_tab = document, True
        if line:
            self.cursor = (line, max(column, 1))
        return document

    def close(self, document: CodeDocument) -> None:
        """Close without asking."""
        at = self.documents.index(document)
        self.documents.remove(document)
        if self.front is document:
            self.front = self.documents[min(at, len(self.documents) - 1)] if self.documents else None
            self.raise_tab = True

    def look(self) -> None:
        """See what was changed elsewhere."""
        for document in self.documents:
            document.look()

    @property
    def dirty(self) -> list[CodeDocument]:
        return [d for d in self.documents if d.dirty]

    def copy_into(self, document: CodeDocument, root: Path) -> CodeDocument:
        """Copy a built-in file to its place in the project at `root`, where it goes before the built-in one, and open
        it in its stead. A file that is there already is opened as it is. Raises InputError, OutputError."""
        if not is_built_in(document.path):
            raise InputError("is not one of the built-in shaders", where=document.path)
        target = root / "shaders" / document.path.relative_to(shaders_dir().resolve())
        if not target.exists():
            write_bytes(target, document.path.read_bytes())
        self.close(document)
        return self.open(target)


def is_built_in(path: Path) -> bool:
    """Whether it is one of Lucarna's own shaders."""
    return path.resolve().is_relative_to(shaders_dir().resolve())


def is_read_only(path: Path) -> bool:
    """The shaders of an installed copy are not to be changed: an update would replace them."""
    installed = data_root().name == "lucarna_data"
    return (installed and is_built_in(path)) or not os.access(path, os.W_OK)
