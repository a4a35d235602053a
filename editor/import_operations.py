"""Operations on the import of the document in front: again, its card, its settings, one-click fixes."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

from editor import import_settings, reimporting
from editor.arguments import Argument
from editor.import_settings import FIXES, Fix, can_import
from editor.operations import Operation, Operations
from editor.session import Session


def add_import_operations(ops: Operations) -> None:
    """Add them all to the registry."""
    ops.add(
        Operation(
            "file.reimport", "Import the source again", _again, "File", ("Ctrl+Alt+R",), can_import, separator=True,
            doc="Your changes are kept; where the source changed the same, yours win and the log says so",
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "file.reimport-on-change", "Import sources again when they change", _toggle_watch, "File",
            checked=lambda s: s.preferences.reimport,
        )
    )  # fmt: skip
    ops.add(
        Operation(
            "file.import-card", "Import card", _toggle_card, "File", enabled=can_import,
            checked=lambda s: s.ui.import_card, doc="Size, axes, counts, warnings and one-click fixes",
        )
    )  # fmt: skip
    for fix in FIXES:
        ops.add(Operation(f"import.{fix.id}", f"Import: {fix.label}", _fixer(fix), enabled=can_import, doc=fix.doc))
    ops.add(
        Operation(
            "import.set", "Set an import setting", _set, enabled=can_import, sample=_sample,
            arguments=(
                Argument("setting", "enum", choices=lambda s: _known()),
                Argument("value", "value", None, doc="None: as by default"),
            ),
            doc="One of `lucarna convert --help`, kept in the sidecar of the source",
        )
    )  # fmt: skip


def _again(session: Session) -> None:
    reimporting.start(session)


def _toggle_watch(session: Session) -> None:
    session.preferences.reimport = not session.preferences.reimport
    session.remember()


def _toggle_card(session: Session) -> None:
    requests = session.ui
    requests.import_card = requests.import_card_opened = not requests.import_card or requests.import_card_folded


def _fixer(fix: Fix) -> Callable[[Session], None]:
    return lambda session: import_settings.apply_fix(session, fix)


def _set(session: Session, setting: str, value: Any) -> None:
    import_settings.change(session, {setting: value})


def _known() -> tuple[str, ...]:
    from importers.settings import OUTPUT_GROUPS, declared

    return tuple(info.name for info in declared().values() if info.group in OUTPUT_GROUPS)


def _sample(session: Session, dice: random.Random) -> dict[str, Any]:
    setting, value = dice.choice([("scale", 2.0), ("turn", "z-up"), ("two_sided", True), ("scale", None)])
    return {"setting": setting, "value": value}
