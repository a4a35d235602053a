"""The editor's tests share a fake engine, which lies in support/ and is importable by name."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "support"))


@pytest.fixture(autouse=True)
def _own_settings(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    """No test reads or writes the user's own settings folder."""
    monkeypatch.setenv("LUCARNA_CONFIG", str(tmp_path_factory.mktemp("config")))
