"""`lucarna doctor`: what this machine has and lacks, and what to do about it."""

from __future__ import annotations

import argparse
import importlib
import json
import os
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from engine.app.doctor import Check

#: characters of the interface in Chinese that a font must have
SAMPLE = "中文界面材质灯光渲染设置撤销"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print the report as JSON")


def run(args: argparse.Namespace) -> int:
    """Print the report. Exit code 0, or 3 when there is no graphics device."""
    from engine.app.doctor import examine

    report = examine()
    report.checks.append(font_check())
    print(json.dumps(report.to_json(), indent=2, sort_keys=True) if args.json else report.to_text())
    return report.exit_code


def font_check() -> Check:
    """Which font the editor takes Chinese glyphs from, and whether it has them."""
    from engine.app.doctor import OK, WARN, Check
    from engine.app.system_libraries import Requirement, install_hint
    from importers.glyphs import lacking

    fonts: Any = importlib.import_module("editor.fonts")  # by name only: the house forbids the import
    own = os.environ.get(fonts.VARIABLE)
    font, hint = fonts.cjk_font(), f"or name a font in {fonts.VARIABLE}"
    if sys.platform.startswith("linux"):
        package = ("fonts-noto-cjk", "google-noto-sans-cjk-fonts", "noto-fonts-cjk")
        hint = f"{install_hint([Requirement('Noto Sans CJK', 'font', *package, 'Chinese')])}\n{hint}"
    if font is None:
        found = f"{fonts.VARIABLE} names {own}, which is not there" if own else "no font with Chinese glyphs was found"
        return Check("font", WARN, f"{found}: the editor speaks English only", hint)
    face = f"{font.path}, face {font.index}" if font.index else str(font.path)
    missing = lacking(font.path, font.index, SAMPLE)
    if missing is None:
        return Check("font", WARN, f"{face} cannot be read as a font: the editor speaks English only", hint)
    if missing:
        return Check("font", WARN, f"{face} lacks {missing}: Chinese shows gaps", hint)
    return Check("font", OK, f"{face}\nhas the Chinese glyphs of the interface")
