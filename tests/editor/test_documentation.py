"""The generated documents: every row leads somewhere, and what lies in docs/ is what would be written now."""

from __future__ import annotations

from pathlib import Path

import pytest

from editor import documentation
from editor.builtin_operations import builtin_operations
from editor.features import FEATURES, Feature
from editor.navigation import MOTIONS
from editor.strings.listing import panel_titles
from importers.cli.main import COMMANDS

OPERATIONS = {o.id for o in builtin_operations()}


@pytest.mark.parametrize("feature", FEATURES, ids=lambda feature: feature.name)
def test_every_row_leads_somewhere(feature: Feature) -> None:
    assert set(feature.operations) <= OPERATIONS, set(feature.operations) - OPERATIONS
    assert set(feature.panels) <= set(panel_titles())
    assert set(feature.commands) <= set(COMMANDS)
    assert set(feature.motions) <= set(MOTIONS)
    assert (  # what leads nowhere is said to be missing
        feature.operations or feature.panels or feature.commands or feature.missing
    )


def test_the_floor_of_the_first_release_is_whole() -> None:
    floor = [f for f in FEATURES if f.first]
    assert len(floor) == 18
    assert [f.name for f in floor if not (f.operations or f.panels or f.commands)] == []


def test_a_row_whose_operation_vanished_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    operations = builtin_operations()
    operations.remove("help.palette")
    with pytest.raises(KeyError):
        documentation.features_text(operations)


def test_the_documents_are_up_to_date(tmp_path: Path) -> None:
    assert documentation.stale() == [], "run `python -m editor.documentation`"
    assert documentation.stale(tmp_path) == [Path("features.md"), Path("operations.md")]


def test_every_operation_is_listed_with_its_arguments() -> None:
    text = documentation.operations_text(builtin_operations())
    for id in OPERATIONS:
        assert f"| `{id}` |" in text
    assert "`axis: enum (x \\| y \\| z) = 'y'`" in text
