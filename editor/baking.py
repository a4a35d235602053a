"""Surroundings that are baked in a thread while the window goes on: whether there are such, and when one is there."""

from __future__ import annotations

from typing import Any


def _environments(runtime: Any) -> Any:
    return getattr(getattr(runtime, "renderer", None), "environments", None)


def surroundings_revision(runtime: Any) -> int:
    """Grows when surroundings are there that a picture waits for."""
    return int(getattr(_environments(runtime), "baked", 0))


def surroundings_waiting(session: Any) -> bool:
    """Whether the document in front is lit by others than it asks for, until those are baked."""
    document = session.document
    return document is not None and bool(getattr(_environments(document.runtime), "baking", 0))
