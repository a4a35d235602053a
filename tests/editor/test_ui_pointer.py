"""UI tests of mouse, trackpad and keys in the viewport: real clicks on a null platform, each reported by its name."""

from __future__ import annotations

import pytest

from tests.support import ui_scripts

SCRIPT = "pointer_ui.py"


@pytest.fixture(scope="module")
def results() -> dict[str, str]:
    return ui_scripts.run(SCRIPT)


@pytest.mark.parametrize("name", ui_scripts.names(SCRIPT))
def test_ui(results: dict[str, str], name: str) -> None:
    assert name in results, "the test did not run"
    assert not results[name], results[name]
