"""`lucarna inspect FILE`: describe any source or engine file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from importers.cli.output import print_findings, print_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="a source, .lmesh, .lanim, .dds, .material.toml, .scene.json …")
    parser.add_argument("--allow-outside", action="store_true", help="follow URIs that leave the source's folder")
    parser.add_argument("--scene", metavar="FILE", type=Path, help="an effect: the variants that this scene uses")
    parser.add_argument("--source", action="store_true", help="an effect: its flattened sources and generated blocks")
    parser.add_argument("--features", default="", metavar="A,B", help="an effect: features of the sources shown")
    parser.add_argument("--json", action="store_true", help="print one JSON value instead of text")


def run(args: argparse.Namespace) -> int:
    """Exit code 1 where the file has errors, as `check` has."""
    from importers.inspection import describe
    from importers.settings import ImportSettings

    description, findings = describe(
        Path(args.file), ImportSettings(allow_outside=args.allow_outside), scene=args.scene,
        features=tuple(name for name in args.features.split(",") if name),
    )  # fmt: skip
    if args.json:
        print_json(description | {"findings": [finding.to_json() for finding in findings]})
    else:
        _tell_variants(description)
        sources = {"generated": description.pop("generated", []), **description.pop("sources", {})}
        print("\n".join(_lines(description, 0)))
        for name, lines in sources.items() if args.source else ():
            print("\n".join(["", f"{name}:", *(f"  {line}" for line in lines)]))
        print_findings(findings)
    return 1 if findings.has_errors else 0


def _tell_variants(description: dict[str, Any]) -> None:
    """In text, what made a variant exist is enough; why the rest is off, and whole errors, are in the JSON."""
    for variant in description.get("variants", []):
        variant.pop("absent", None)
        variant.pop("streams", None)
        variant["features"] = variant["features"] or ["none"]
        variant["reasons"] = [f"{name}: {reason}" for name, reason in variant["reasons"].items()]
        variant["error"] = variant["error"].split("\n")[0]


def _lines(values: dict[str, Any], depth: int) -> list[str]:
    """The description as indented text: small values on one line, lists of objects one line each."""
    indent, lines = "  " * depth, []
    for key, value in values.items():
        if value in (None, "", [], {}):
            continue
        title = key.replace("_", " ")
        if isinstance(value, dict) and any(isinstance(v, (dict, list)) for v in value.values()) and depth == 0:
            lines += [f"{indent}{title}:", *_lines(value, depth + 1)]
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            lines.append(f"{indent}{title}: {len(value)}")
            lines += [f"{indent}  {_short(item)}" for item in value]
        else:
            lines.append(f"{indent}{title}: {_short(value)}")
    return lines


def _short(value: Any) -> str:
    if isinstance(value, dict):
        given = {k: v for k, v in value.items() if v not in (None, "", [], {}) or v == 0}
        return ", ".join(f"{k.replace('_', ' ')} {_short(v)}" for k, v in given.items())
    if isinstance(value, list):
        if all(isinstance(v, (int, float)) for v in value):
            return " ".join(map(str, value))
        return ", ".join(map(_short, value))
    return f"{value:,}" if isinstance(value, int) and not isinstance(value, bool) else str(value)
