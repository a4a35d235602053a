"""The quality of `lucarna render`: a preset by name, or the best one within a budget of milliseconds."""

from __future__ import annotations

import argparse
import math
import sys
from typing import TYPE_CHECKING, Any

from engine.core.errors import UsageError

if TYPE_CHECKING:
    from engine.app.runtime import Runtime
    from engine.render.settings import RenderSettings
    from engine.render.view import View

#: engine.render.presets.NAMES, said here so that --help stays quick
CHOICES = ("low", "medium", "high", "ultra", "auto")


def add_quality_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--quality", choices=CHOICES,
        help="a preset; auto: the best whose frame stays within --budget-ms, measured on this device with this scene",
    )  # fmt: skip
    parser.add_argument("--budget-ms", type=float, metavar="MS", help="milliseconds of a frame, for --quality auto")


def check_quality(args: argparse.Namespace) -> None:
    """Raises UsageError where the arguments do not go together."""
    budget = args.budget_ms
    if args.quality == "auto" and budget is None:
        raise UsageError("--quality auto has no budget", hint="say how long a frame may take, as --budget-ms 16")
    if budget is not None and args.quality != "auto":
        raise UsageError("--budget-ms without --quality auto", hint="add --quality auto")
    if budget is not None and not (math.isfinite(budget) and budget > 0.0):
        raise UsageError(f"--budget-ms {budget:g}: expected milliseconds above 0")


def with_quality(args: argparse.Namespace, settings: RenderSettings, named: dict[str, object]) -> RenderSettings:
    """The settings with the preset that is asked for by name; what `named` holds was asked for by itself and stays."""
    from engine.render.presets import PRESETS

    if args.quality is None or args.quality == "auto":
        return settings
    return type(settings)(**{**settings.values(), **PRESETS[args.quality], **named})


def with_samples(named: dict[str, Any]) -> dict[str, Any]:
    """What the arguments name, and one sample a pixel where that needs it and none says how many. Raises UsageError."""
    from engine.render.one_sample import along
    from engine.render.settings import RenderSettings

    settings = RenderSettings(**named).values()
    return {**named, **along({name: settings[name] for name in named}, int(RenderSettings().samples))}


def print_idle(settings: RenderSettings) -> None:
    """Say on stderr which settings do nothing beside others."""
    from engine.render.one_sample import idle

    for name, why in idle(settings.values()).items():
        print(f"{name} does nothing: it {why}", file=sys.stderr)


def auto_quality(args: argparse.Namespace, runtime: Runtime, view: View, named: dict[str, object]) -> RenderSettings:
    """For `auto`, the settings of the preset that fits, and a line on stderr that says which and why."""
    if args.quality != "auto":
        return view.settings
    from engine.app.calibration import choose
    from engine.render.presets import PRESETS

    chosen = choose(runtime, view, args.budget_ms)
    print("\n".join(chosen.table), file=sys.stderr)
    print(f"{'' if chosen.within else 'warning: '}quality {chosen.why}", file=sys.stderr)
    return type(view.settings)(**{**view.settings.values(), **PRESETS[chosen.preset], **named})
