"""Finds experiments: every module in engine/experiments with an `EXPERIMENT` is one, named as its file.

Packages above the engine bring theirs by `include`: the engine knows only what it is told.
"""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from collections.abc import Sequence

from engine.core.errors import UsageError
from engine.experiments.harness.experiment import Experiment

_packages = ["engine.experiments"]

#: a name for several that belong together
GROUPS: dict[str, tuple[str, ...]] = {
    "shadows": ("sun_shadows", "local_shadows", "translucent_shadows", "shadow_edges", "shadow_filter"),
}


def include(package: str) -> None:
    """Look for experiments in `package`, too."""
    if package not in _packages:
        _packages.append(package)


def names() -> list[str]:
    """All experiments' names, sorted."""
    return sorted(_modules())


def _modules() -> dict[str, str]:
    """Name -> module."""
    found: dict[str, str] = {}
    for package in _packages:
        paths = importlib.import_module(package).__path__
        found |= {m.name: f"{package}.{m.name}" for m in pkgutil.iter_modules(paths) if not m.ispkg}
    return found


def get(name: str) -> Experiment:
    """The experiment of that name; `-` and `_` are one. Raises UsageError with "did you mean"."""
    wanted, known = name.replace("-", "_"), _modules()
    if wanted not in known:
        near = difflib.get_close_matches(wanted, [*known, *GROUPS], 1)
        raise UsageError(
            f"there is no experiment {name!r}",
            hint=f"did you mean {near[0]!r}?" if near else "`lucarna report` lists them",
        )
    found = importlib.import_module(known[wanted]).EXPERIMENT
    assert isinstance(found, Experiment), f"{known[wanted]}: EXPERIMENT is no Experiment"
    return found


def select(wanted: Sequence[str]) -> dict[str, Experiment]:
    """Name -> experiment, in the order asked for, groups taken apart; all of them for none."""
    plain = [n.replace("-", "_") for n in wanted] or names()
    chosen = [name for n in plain for name in GROUPS.get(n, (n,))]
    return {name: get(name) for name in dict.fromkeys(chosen)}
