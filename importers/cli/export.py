"""`lucarna export SCENE|FILE --out X.glb|X.obj`: scenes back out of the engine, whole or posed.

.glb: everything, with clips (only --clip NAME where given); with --time or --frame the pose of that moment, baked.
.obj: the posed geometry.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from engine.core.errors import UsageError

if TYPE_CHECKING:
    from engine.assets.clip import ClipAsset


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("source", metavar="SCENE|FILE", help="a *.scene.json, or any source that can be imported")
    parser.add_argument(
        "--out", required=True, metavar="X.glb", help="the file to write: .glb (everything) or .obj (posed geometry)"
    )
    parser.add_argument(
        "--clip", metavar="NAME", help="this clip alone (without it: .glb all clips; --time or --frame: the first)"
    )
    moment = parser.add_mutually_exclusive_group()
    moment.add_argument("--time", type=float, metavar="S", help="seconds from the clip's start (default 0)")
    moment.add_argument(
        "--frame", type=float, metavar="N", help="frame number of the source, at its own frame rate (30 if it has none)"
    )
    parser.add_argument("--hidden", action="store_true", help="write hidden nodes, too")
    parser.add_argument("--allow-outside", action="store_true", help="follow URIs that leave the source's folder")
    parser.add_argument("--quiet", action="store_true", help="print errors only")


def run(args: argparse.Namespace) -> int:
    """Without --clip, --time and --frame an .obj shows the scene as it stands."""
    from engine.core.errors import InputError
    from importers.cli.output import print_findings
    from importers.export.obj import find_clip, time_of_frame
    from importers.presets import resolve
    from importers.settings import ImportSettings

    out, source = Path(args.out), Path(args.source)
    kind = out.suffix.lower()
    if kind not in (".obj", ".glb"):
        raise UsageError(f"--out {args.out!r}: only .glb and .obj can be written", hint="give a name that ends so")
    if not os.path.exists(source):  # noqa: PTH110  (false for names that no file can have, too)
        from importers.gltf.uris import similar_name_hint

        raise InputError("there is no such file", where=source, hint=similar_name_hint(source))
    settings = resolve(source, ImportSettings(allow_outside=args.allow_outside)).settings
    moment = args.time is not None or args.frame is not None

    def chosen(clips: list[ClipAsset]) -> tuple[ClipAsset | None, float]:
        clip = find_clip(clips, args.clip) if args.clip is not None else clips[0] if moment and clips else None
        if clip is None:
            return None, 0.0
        return clip, args.time or 0.0 if args.frame is None else time_of_frame(clip, args.frame)

    if kind == ".obj":
        from importers.export.obj import export_obj, load_geometry

        geometry = load_geometry(source, settings)
        clip, time = chosen(geometry.clips)
        findings = geometry.findings
        export_obj(out, geometry, clip, time, hidden=args.hidden)
    else:
        from importers.export.glb import export_glb
        from importers.export.source import load_source, posed

        scene = load_source(source, settings)
        clip, time = chosen(scene.clips)
        findings = scene.findings
        if moment:
            scene = posed(scene, clip, time, hidden=args.hidden)
        elif clip is not None:
            scene.clips = [clip]
        export_glb(out, scene)
    if not args.quiet:
        print_findings(findings)
        when = f", {clip.name} at {max(time, 0.0):.4g} s" if clip is not None and (moment or kind == ".obj") else ""
        print(f"{out}{when}")
    return 0
