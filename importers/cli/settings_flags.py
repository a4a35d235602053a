"""Flags for the settings of an import, made from their declarations in importers/settings.py."""

from __future__ import annotations

import argparse
from typing import Any

from engine.core.errors import UsageError
from importers.settings import Setting, declared

_TYPES = {"int": int, "float": float, "str": str}


def add_settings(parser: argparse.ArgumentParser) -> None:
    """One flag for each setting but those of how the work is done; a bool that is true by default gets `--no-…`, and
    where the command has a flag of that name itself, the setting's begins with `--import-`. Call it last."""
    parser.add_argument("--preset", metavar="NAME", default="", help="draft, normal, high, final, one of the project's "
                        "own, or a .toml file")  # fmt: skip
    groups: dict[str, Any] = {}
    for info in flagged():
        if info.group not in groups:
            groups[info.group] = parser.add_argument_group(f"{info.group} (also in sidecars and presets)")
        group, dest = groups[info.group], f"setting_{info.name}"
        name = f"--no-{info.flag[2:]}" if info.kind == "bool" and info.default else info.flag
        flag = f"--import-{name[2:]}" if name in parser._option_string_actions else name
        if info.kind == "bool":
            text = f"do not: {info.doc}" if info.default else info.doc
            group.add_argument(flag, dest=dest, action="store_const", const=not info.default, help=text)
        elif info.kind == "list":
            group.add_argument(flag, dest=dest, metavar="A,B", help=info.doc)
        else:
            default = f"default {info.default}" if info.default != "" else ""
            about = ", ".join(part for part in (" ".join(info.choices), info.unit, default) if part)
            group.add_argument(
                flag, dest=dest, type=_TYPES[info.kind], metavar="N" if info.kind != "str" else "WORD",
                help=f"{info.doc} ({about})".replace("%", "%%"),
            )  # fmt: skip


def given_settings(args: argparse.Namespace) -> dict[str, Any]:
    """The settings that the command line names, checked. Raises UsageError, which names the flag."""
    values = {}
    for info in flagged():
        value = getattr(args, f"setting_{info.name}", None)
        if value is not None:
            if info.kind == "list":
                value = tuple(part for part in value.split(",") if part)
            try:
                values[info.name] = info.check(value)
            except UsageError as error:
                raise UsageError(f"{info.flag}: {error.message}", hint=error.hint) from None
    return values


def flagged() -> list[Setting]:
    """The settings that have a flag."""
    return [info for info in declared().values() if info.flag and info.group != "run"]
