"""`lucarna lights SCENE --out OUT`: scatter many lights over a scene, still or drifting, or repeat what it has.

`--set NAME=VALUE` takes any setting of the scatter, with `--array` of the array, as the editor's Lights panel shows
them.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from engine.core.errors import UsageError

if TYPE_CHECKING:
    from engine.assets.scene import SceneAsset
    from engine.scene.scatter import ScatterSettings


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("scene", metavar="SCENE", type=Path, help="a *.scene.json")
    parser.add_argument("--out", metavar="OUT", type=Path, required=True, help="the scene to write, in the same folder")
    parser.add_argument("--scatter", metavar="N", type=int, help="how many lights (default 100)")
    parser.add_argument(
        "--array", metavar="NODE", help="instead, repeat the node of that name, with all below it (see --set)"
    )
    parser.add_argument(
        "--kind", metavar="KIND", default="point", help="point, spot, rectangle or disk (default point)"
    )
    parser.add_argument("--seed", metavar="N", type=int, default=1, help="another number, another arrangement")
    parser.add_argument(
        "--box", nargs=6, type=float, metavar=("X0", "Y0", "Z0", "X1", "Y1", "Z1"),
        help="where, in metres (default: the box of what the scene draws)",
    )  # fmt: skip
    parser.add_argument(
        "--drift", metavar="M", type=float, default=0.0, help="let them circle by so many metres, as a clip of 16 s"
    )
    parser.add_argument(
        "--set", dest="settings", action="append", default=[], metavar="NAME=VALUE",
        help="scatter: intensity, spread, range, first_color, last_color, all_hues, size, aim. "
        "array: shape (line, grid, ring), count, count_x, count_y, count_z, step, radius, arc, axis, turn",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def run(args: argparse.Namespace) -> int:
    """Write the scene with its lights. Raises UsageError, InputError, FormatError, OutputError."""
    from engine.assets.scene_json import read_scene
    from engine.scene.drift import add_clips, drift_clip, free_name
    from engine.scene.scatter import scatter_lights
    from engine.scene.scene import Scene

    if args.out.resolve().parent != args.scene.resolve().parent:
        raise UsageError(
            "the new scene must lie beside the old one, whose files it names", where=args.out,
            hint=f"for example {args.scene.with_name('lit.scene.json')}",
        )  # fmt: skip
    if not args.out.name.endswith(".scene.json"):
        raise UsageError("the name of a scene ends in .scene.json", where=args.out)
    if args.array is not None:
        return _array(args)
    settings = _settings(args)
    asset = read_scene(args.scene)
    scene = Scene.from_asset(asset)
    low, high = ([0.0] * 3, [1.0] * 3) if settings.box else _box(asset, scene, args.scene.parent)
    top = scatter_lights(scene, settings, low, high)
    out = scene.to_asset(asset)
    written = [args.out]
    if settings.drift > 0.0:
        from engine.assets.lanim import write_lanim
        from engine.scene.convert import parents_first

        file = args.out.with_name(free_name(out, args.out.name.removesuffix(".scene.json")))
        index_of = {row: index for index, row in enumerate(parents_first(scene))}
        moving = add_clips(out, file.name, [drift_clip(scene, top, settings.drift, settings.seed)], index_of)
        write_lanim(file, moving)
        written.insert(0, file)
    return _finish(args, out, written, {"lights": settings.count}, f"scattered {settings.count} {settings.kind} lights")


def _array(args: argparse.Namespace) -> int:
    from engine.assets.records import did_you_mean
    from engine.assets.scene_json import read_scene
    from engine.scene.arrays import ArraySettings, repeat_node

    if args.scatter is not None or args.box or args.drift:
        raise UsageError("--array repeats what is there", hint="scatter in a call of its own, without --array")
    settings = ArraySettings(**_pairs(args))
    asset = read_scene(args.scene)
    names = [node.name for node in asset.nodes]
    if names.count(args.array) != 1:
        few = f"{names.count(args.array)} nodes are named {args.array!r}"
        raise UsageError(few if args.array in names else f"there is no node {args.array!r}",
                         hint=did_you_mean(args.array, names))  # fmt: skip
    added = repeat_node(asset, names.index(args.array), settings)
    told = f"{settings.shape} of {settings.total} {args.array!r}: {added} nodes added"
    return _finish(args, asset, [args.out], {"nodes": added}, told)


def _finish(
    args: argparse.Namespace, out: SceneAsset, written: list[Path], counts: dict[str, int], told: str
) -> int:  # fmt: skip
    """Write the scene, and say so."""
    from engine.assets.scene_json import write_scene

    write_scene(args.out, out)
    if args.json:
        print(json.dumps({**counts, "written": [str(path) for path in written]}))
    else:
        print(f"{told}: {', '.join(path.name for path in written)}")
    return 0


def _settings(args: argparse.Namespace) -> ScatterSettings:
    from engine.scene.scatter import ScatterSettings

    count = 100 if args.scatter is None else args.scatter
    values: dict[str, object] = {"kind": args.kind, "count": count, "seed": args.seed, "drift": args.drift}
    if args.box:
        values |= {"box": True, "box_low": args.box[:3], "box_high": args.box[3:]}
    return ScatterSettings(**values | _pairs(args))


def _pairs(args: argparse.Namespace) -> dict[str, object]:
    values: dict[str, object] = {}
    for item in args.settings:
        name, found, value = item.partition("=")
        if not found:
            raise UsageError(f"--set {item!r}: expected NAME=VALUE")
        values[name.strip()] = value
    return values


def _box(asset: SceneAsset, scene: object, folder: Path) -> tuple[list[float], list[float]]:
    """The world box of all that the scene draws. Raises UsageError where it draws nothing."""
    import numpy as np

    from engine.assets.lmesh import read_lmesh
    from engine.scene.scene import Scene

    assert isinstance(scene, Scene)
    files: dict[str, list[tuple[list[float], list[float]]]] = {}
    corners = []
    for node, row in zip(asset.nodes, scene.row_of_node.tolist(), strict=True):
        if node.mesh is None:
            continue
        if node.mesh.file not in files:
            files[node.mesh.file] = [
                (
                    np.min([s.bounds_min for s in m.submeshes], axis=0),
                    np.max([s.bounds_max for s in m.submeshes], axis=0),
                )
                for m in read_lmesh(folder / node.mesh.file)
            ]
        ends = np.array(files[node.mesh.file][node.mesh.index])
        bits = np.array([[(k >> axis) & 1 for axis in range(3)] for k in range(8)])
        box = np.take_along_axis(ends, bits, axis=0)
        matrix = scene.nodes.world_matrix(row)
        corners.append(box @ matrix[:3, :3].T + matrix[:3, 3])
    if not corners:
        raise UsageError("the scene draws nothing to scatter lights over", hint="give --box X0 Y0 Z0 X1 Y1 Z1")
    points = np.concatenate(corners)
    return points.min(axis=0).tolist(), points.max(axis=0).tolist()
