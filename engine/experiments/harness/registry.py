"""Finds experiments: every module in engine/experiments with an `EXPERIMENT` is one, named as its file."""

from __future__ import annotations

import difflib
import importlib
import pkgutil
from collections.abc import Sequence

import engine.experiments
from engine.core.errors import UsageError
from engine.experiments.harness.experiment import Experiment


def names() -> list[str]:
    """All experiments' names, sorted."""
    return sorted(m.name for m in pkgutil.iter_modules(engine.experiments.__path__) if not m.ispkg)


def get(name: str) -> Experiment:
    """The experiment of that name; `-` and `_` are one. Raises UsageError with "did you mean"."""
    wanted, known = name.replace("-", "_"), names()
    if wanted not in known:
        near = difflib.get_close_matches(wanted, known, 1)
        raise UsageError(
            f"there is no experiment {name!r}",
            hint=f"did you mean {near[0]!r}?" if near else "`lucarna report` lists them",
        )
    found = importlib.import_module(f"engine.experiments.{wanted}").EXPERIMENT
    assert isinstance(found, Experiment), f"engine/experiments/{wanted}.py: EXPERIMENT is no Experiment"
    return found


def select(wanted: Sequence[str]) -> dict[str, Experiment]:
    """Name -> experiment, in the order asked for; all of them for none."""
    chosen = [n.replace("-", "_") for n in wanted] or names()
    return {name: get(name) for name in dict.fromkeys(chosen)}
