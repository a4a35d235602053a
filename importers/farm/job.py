"""Job: one source to convert. Outcome: what became of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from importers.settings import ImportSettings

#: what an outcome may be, from best to worst
STATES = ("up to date", "cached", "converted", "would convert", "failed")


@dataclass(frozen=True, slots=True)
class Job:
    """Convert `source` into `folder`, its files beginning with `name`. `origins`: where each setting is from."""

    source: Path
    folder: Path
    name: str
    settings: ImportSettings = field(default_factory=ImportSettings)
    origins: dict[str, str] = field(default_factory=dict, hash=False)


@dataclass(frozen=True, slots=True)
class Output:
    """A file that was made: its name in the job's folder. `changed`: its bytes are not those that were there."""

    name: str
    size: int
    digest: str
    changed: bool = True

    def to_json(self) -> dict[str, Any]:
        return {"name": self.name, "size": self.size, "digest": self.digest}


@dataclass(slots=True)
class Outcome:
    """`state`: of STATES; `reasons`: why it was not up to date; `findings`: JSON; `error`: with `failed`, one text;
    `exit_code`: what this outcome alone would end the process with; `removed`: outputs that are made no more; `inputs`,
    `folders`: what was read besides the source, relative to its folder."""

    job: Job
    state: str
    reasons: list[str] = field(default_factory=list)
    outputs: list[Output] = field(default_factory=list)
    findings: list[dict[str, Any]] = field(default_factory=list)
    error: str = ""
    exit_code: int = 0
    seconds: float = 0.0
    timings: dict[str, float] = field(default_factory=dict)
    removed: list[str] = field(default_factory=list)
    inputs: list[str] = field(default_factory=list)
    folders: list[str] = field(default_factory=list)
    scene: str = ""
    key: str = ""

    @property
    def has_errors(self) -> bool:
        return bool(self.error) or any(finding["severity"] == "error" for finding in self.findings)

    def to_json(self) -> dict[str, Any]:
        folder = self.job.folder
        return {
            "source": str(self.job.source), "state": self.state, "reasons": self.reasons, "error": self.error,
            "scene": str(folder / self.scene) if self.scene else "", "key": self.key, "findings": self.findings,
            "outputs": [
                {"path": str(folder / o.name), "bytes": o.size, "digest": o.digest, "changed": o.changed}
                for o in self.outputs
            ],
            "removed": self.removed, "seconds": {"total": self.seconds} | self.timings,
            "settings": self.job.settings.differences(),
        }  # fmt: skip
