"""`lucarna run`: a thin door to the editor, which importers may not import by name."""

from __future__ import annotations

import argparse
import importlib
from typing import Any


def _command() -> Any:
    return importlib.import_module("editor.run_command")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    _command().add_arguments(parser)


def run(args: argparse.Namespace) -> int:
    return int(_command().run(args))
