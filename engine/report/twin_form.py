"""The form of a report's JSON twin, as far as comparing needs it; what else is in there may be anything."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from engine.core.errors import FormatError, Place


class _Milliseconds(BaseModel):
    median: float | None
    iqr: float | None
    kind: str = "wall"


class _Point(BaseModel):
    knobs: dict[str, Any] | None = None
    error: dict[str, float | None] | None = None
    ms: _Milliseconds | None = None


class _Order(BaseModel):
    curve: str
    over: str
    expected: float
    observed: float | None
    met: bool


class _Extreme(BaseModel):
    what: str
    found: str
    ok: bool


class _Experiment(BaseModel):
    name: str
    points: list[_Point]
    default: dict[str, Any] | None = None
    default_on_front: bool | None = None
    orders: list[_Order] | None = None
    extremes: list[_Extreme] | None = None


class _Twin(BaseModel):
    experiments: list[_Experiment]


def check_twin(data: object, path: Path) -> None:
    """Raise FormatError with the place of the first value that is not as `lucarna report` writes it."""
    try:
        _Twin.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in first["loc"]).removeprefix(".")
        said = "expected an object" if first["type"] == "model_type" else first["msg"]
        message = f"no report: {said[:1].lower()}{said[1:]}"
        hint = "give a report.json of `lucarna report`"
        raise FormatError(message, where=Place(str(path), path=place), hint=hint) from error
