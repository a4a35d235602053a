"""`--set objects.NODE.PARAMETER=VALUE`: a parameter of a material, on the objects of that name alone."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from engine.core.errors import UsageError

if TYPE_CHECKING:
    from engine.app.runtime import Runtime

PREFIX = "objects."


def set_objects(runtime: Runtime, items: Iterable[str]) -> None:
    """Apply those of the `--set` items that are about objects. Raises UsageError (did you mean)."""
    for item in items:
        name, _, value = item.partition("=")
        if name.strip().startswith(PREFIX):
            node, dot, param = name.strip().removeprefix(PREFIX).rpartition(".")
            if not dot:
                raise UsageError(f"--set {item!r}: expected {PREFIX}NODE.PARAMETER=VALUE")
            runtime.objects.named(node, param, value.strip())
