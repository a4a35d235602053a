"""The document's camera bookmarks as a table: its rows are their numbers. No imgui.

column "camera": (target, yaw, pitch, roll, distance, yfov, orthographic), None where there is no bookmark
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, fields
from typing import Any

from editor.camera_controls import OrbitCamera
from engine.assets.scene import BookmarkAsset, SceneAsset

BOOKMARKS, COLUMN = "bookmarks", "camera"


class BookmarkTable:
    """See editor.tables.Table; `bookmarks` is the document's own."""

    def __init__(self, bookmarks: dict[int, OrbitCamera]) -> None:
        self._bookmarks = bookmarks

    def read(self, column: str, rows: Sequence[int]) -> tuple[Any, ...]:
        return tuple(to_plain(self._bookmarks.get(row)) for row in rows)

    def write(self, column: str, rows: Sequence[int], values: Sequence[Any]) -> None:
        for row, value in zip(rows, values, strict=True):
            if value is None:
                self._bookmarks.pop(row, None)
            else:
                self._bookmarks[row] = from_plain(value)


def to_plain(camera: OrbitCamera | None) -> tuple[Any, ...] | None:
    return None if camera is None else astuple(camera)


def from_plain(value: Sequence[Any]) -> OrbitCamera:
    return OrbitCamera(tuple(value[0]), *value[1:])


def of_asset(asset: SceneAsset) -> dict[int, OrbitCamera]:
    """The bookmarks of a scene file as cameras."""
    names = [field.name for field in fields(OrbitCamera)]
    return {mark.number: OrbitCamera(*(getattr(mark, name) for name in names)) for mark in asset.bookmarks}


def save_to(asset: SceneAsset, number: int, value: Sequence[Any] | None) -> None:
    """Put an edit of the table into a scene."""
    kept = [mark for mark in asset.bookmarks if mark.number != number]
    if value is not None:
        kept.append(BookmarkAsset(number, tuple(value[0]), *value[1:]))
    asset.bookmarks = sorted(kept, key=lambda mark: mark.number)
