"""What an import, check or load noticed: a list of findings, each with severity, place, message and what to do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from typing import Any

from engine.core.errors import Place


class Severity(StrEnum):
    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


NOWHERE = Place()


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing noticed. `code` is a stable short name (`gltf.index-range`) for filters and tests."""

    severity: Severity
    code: str
    message: str
    where: Place = NOWHERE
    hint: str = ""

    def __str__(self) -> str:
        place = str(self.where)
        text = f"{self.severity.value}: {place + ': ' if place else ''}{self.message}"
        return f"{text} ({self.hint})" if self.hint else text

    def to_json(self) -> dict[str, Any]:
        data = asdict(self)
        data["severity"] = self.severity.value
        return data


@dataclass(slots=True)
class Findings:
    """Collects findings, each once; `file` is filled in for every place that names none.

    Beyond `limit` they are only counted, in `left_out`: a broken file may hold a million mistakes.
    """

    file: str = ""
    items: list[Finding] = field(default_factory=list)
    limit: int = 500
    left_out: int = 0

    def add(self, severity: Severity, code: str, message: str, path: str = "", hint: str = "") -> None:
        finding = Finding(severity, code, message, Place(self.file, path=path), hint)
        if len(self.items) >= self.limit:
            self.left_out += 1
        elif finding not in self.items:
            self.items.append(finding)

    def info(self, code: str, message: str, path: str = "", hint: str = "") -> None:
        self.add(Severity.INFO, code, message, path, hint)

    def warn(self, code: str, message: str, path: str = "", hint: str = "") -> None:
        self.add(Severity.WARNING, code, message, path, hint)

    def error(self, code: str, message: str, path: str = "", hint: str = "") -> None:
        self.add(Severity.ERROR, code, message, path, hint)

    @property
    def has_errors(self) -> bool:
        return any(f.severity is Severity.ERROR for f in self.items)

    def __iter__(self) -> Iterator[Finding]:
        return iter(self.items)

    def __len__(self) -> int:
        return len(self.items)
