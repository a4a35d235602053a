"""Operations for quality presets: one entry of the undo history each."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from editor.arguments import REQUIRED, Argument
from editor.operations import Operation, Operations
from editor.session import Session
from engine.render.presets import AUTO, NAMES, PRESETS


def add_quality_operations(ops: Operations) -> None:
    """A preset of each name, and the best one within a budget."""
    for i, name in enumerate(NAMES):
        ops.add(Operation(
            f"view.quality-{name}", f"Quality: {name}", _preset(name), "View", (), _has_document, _is(name), i == 0,
            f"Set what {name} quality is made of; see Render settings",
        ))  # fmt: skip
    ops.add(Operation(
        f"view.quality-{AUTO}", "Quality: the best within a budget", fit_budget, "", (), _has_document, None, False,
        "Measures a few frames of every preset with this scene on this device, once",
        (Argument("milliseconds", "float", REQUIRED, 0.1, 10000.0, unit="ms", doc="that a frame may take"),),
    ))  # fmt: skip


def fit_budget(session: Session, milliseconds: float) -> None:
    """Set the best preset whose frame fits; the log says what was measured."""
    from engine.app.calibration import choose

    assert session.document is not None, "the operation is not enabled without"
    runtime: Any = session.document.runtime
    with session.device_frame():
        chosen = choose(runtime, session.view(), milliseconds)
    session.apply_settings(PRESETS[chosen.preset], f"Quality: {chosen.preset}")
    (session.messages.info if chosen.within else session.messages.warn)(
        "\n".join((f"quality {chosen.why}", *chosen.table))
    )


def current(session: Session) -> str:
    """The preset that the settings are; '' for none."""
    values = {p.name: getattr(session.settings, p.name) for p in session.settings.PARAMS}
    return next((n for n in NAMES if all(values.get(k) == v for k, v in PRESETS[n].items())), "")


def _preset(name: str) -> Callable[[Session], None]:
    return lambda session: session.apply_settings(PRESETS[name], f"Quality: {name}")


def _is(name: str) -> Callable[[Session], bool]:
    return lambda session: current(session) == name


def _has_document(session: Session) -> bool:
    return session.document is not None
