"""What a panel is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from pathlib import Path
from typing import ClassVar

from editor.strings import tr
from editor.ui import Ui

#: drag payload of a file from the assets panel; which one: session.ui.dragged
ASSET = "asset"


class Panel(ABC):
    """`title` names the window and keys its place in the saved layout; `dock` is one of layout.DOCKS."""

    title: ClassVar[str]
    icon: ClassVar[str] = ""
    dock: ClassVar[str]
    #: whether the window keeps the usual space to its border
    padded: ClassVar[bool] = True
    closable: ClassVar[bool] = True
    #: whether it is there before anyone asked for it
    opened: ClassVar[bool] = True

    @property
    def label(self) -> str:
        """The window's label; the part after ### is its identity."""
        shown = tr(self.title)
        return f"{self.icon}  {shown}###{self.title}" if self.icon else f"{shown}###{self.title}"

    @abstractmethod
    def draw(self, ui: Ui) -> None:
        """Draw the content of the window, inside its begin/end. The window draws only when something happens: what
        moves by itself says `ui.again_in(seconds)` each time."""

    def watched(self) -> Iterable[Path]:
        """Files and folders whose change should bring a frame while nothing else happens."""
        return ()
