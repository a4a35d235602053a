"""`lucarna inspect FILE`: describe any source or engine file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from importers.cli.output import print_findings, print_json
from importers.cli.settings_flags import add_settings

#: so many entries of a list are shown as text
MANY = 40


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("file", metavar="FILE", help="a source, .lmesh, .lanim, .dds, .material.toml, .scene.json …")
    parser.add_argument("--scene", metavar="FILE", type=Path, help="an effect: the variants that this scene uses")
    parser.add_argument(
        "--pixels", action="store_true", help="with --scene: which features of its variants never change a pixel of it"
    )
    parser.add_argument("--source", action="store_true", help="an effect: its flattened sources and generated blocks")
    parser.add_argument("--features", default="", metavar="A,B", help="an effect: features of the sources shown")
    parser.add_argument(
        "--brdf", metavar="OUT.png", type=Path, help="a material: draw its lobe, albedo, furnace, terms"
    )
    parser.add_argument("--incidence", metavar="DEGREES", type=float, default=45.0, help="with --brdf: of the light")
    parser.add_argument("--json", action="store_true", help="print one JSON object instead of text")
    parser.add_argument("--details", action="store_true", help="with --json: add what only this kind of file has")
    add_settings(parser)


def run(args: argparse.Namespace) -> int:
    """Exit code 1 where the file has errors, as `check` has."""
    from importers.cli.settings_flags import given_settings
    from importers.inspection import describe
    from importers.presets import SettingsResolver

    path = Path(args.file)
    if args.brdf is not None:
        from importers.brdf_sheet import write_brdf

        told = write_brdf(path, args.brdf, args.incidence)
        print_json({"file": str(path), "brdf": str(args.brdf), "lines": told}) if args.json else print("\n".join(told))
        return 0
    settings = SettingsResolver(preset=args.preset, flags=given_settings(args)).resolve(path).settings
    description, details, findings = describe(
        path,
        settings,
        scene=args.scene,
        features=tuple(name for name in args.features.split(",") if name),
        pixels=args.pixels,
    )
    if args.json:
        print_json(description | ({"details": details} if args.details else {}))
    else:
        description.pop("findings", None)
        head = {key: description.pop(key) for key in ("file", "kind")}
        _shorten(description)
        _tell_variants(description)
        sources = {"generated": description.pop("generated", []), **description.pop("sources", {})}
        print("\n".join(_lines(head | details | description, 0)))
        for name, lines in sources.items() if args.source else ():
            print("\n".join(["", f"{name}:", *(f"  {line}" for line in lines)]))
        print_findings(findings)
    return 1 if findings.has_errors else 0


def _shorten(description: dict[str, Any]) -> None:
    """In text, the tree of nodes is a number, and long lists end early."""
    if description.get("nodes") or description.get("meshes"):
        nodes = description["nodes"]
        description["nodes"] = {"count": len(nodes), "with a mesh": sum("mesh" in node for node in nodes)}
        meshes = description["meshes"]
        boxes = [mesh["bounds"] for mesh in meshes if None not in mesh["bounds"][0] + mesh["bounds"][1]]
        if boxes:
            low = [min(box[0][axis] for box in boxes) for axis in range(3)]
            high = [max(box[1][axis] for box in boxes) for axis in range(3)]
            size = [float(f"{b - a:.6g}") for a, b in zip(low, high, strict=True)]
            description["total"] = {
                "vertices": sum(mesh["vertices"] for mesh in meshes),
                "triangles": sum(mesh["triangles"] for mesh in meshes), "size in metres": size,
            }  # fmt: skip


def _tell_variants(description: dict[str, Any]) -> None:
    """In text, what made a variant exist is enough; why the rest is off, and whole errors, are in the JSON."""
    for variant in description.get("variants", []):
        variant.pop("absent", None)
        variant.pop("streams", None)
        variant.pop("program", None)
        variant["features"] = variant["features"] or ["none"]
        variant["reasons"] = [f"{name}: {reason}" for name, reason in variant["reasons"].items()]
        variant["error"] = variant["error"].split("\n")[0]
        variant["from cache"] = "yes" if variant.pop("from_cache") else ""
    for item in description.get("feature_pixels", []):
        item["error"] = item["error"].split("\n")[0]


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
            lines += [f"{indent}  {_short(item)}" for item in value[:MANY]]
            lines += [f"{indent}  … and {len(value) - MANY:,} more"] * (len(value) > MANY)
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
