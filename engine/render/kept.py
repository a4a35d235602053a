"""What is in textures that stay from frame to frame, part by part: an equal key is an equal picture."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Generic, TypeVar

from engine.gpu.types import Texture

Part = TypeVar("Part", bound=Hashable)

#: textures whose content is remembered: as many as the frame graph keeps views
REMEMBERED = 8


class KeptParts(Generic[Part]):
    """`of(texture)`: part -> key of what was last drawn into it; empty for a texture that is not known."""

    def __init__(self) -> None:
        self._known: list[tuple[Texture, dict[Part, Hashable]]] = []

    def of(self, texture: Texture) -> dict[Part, Hashable]:
        for known, parts in self._known:
            if known is texture:
                return parts
        self._known = [*self._known[1 - REMEMBERED :], (texture, {})]
        return self._known[-1][1]
