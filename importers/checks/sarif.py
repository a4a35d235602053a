"""Findings as SARIF 2.1.0, which code hosts and editors show beside the files.

Format: "Static Analysis Results Interchange Format (SARIF) Version 2.1.0", OASIS Standard, 2020.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from engine import __version__
from engine.core.findings import Finding, Severity

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
LEVELS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "note"}


def sarif_log(reports: Mapping[Path, Sequence[Finding]], base: Path) -> dict[str, Any]:
    """One run over `reports`. Files below `base` are named relative to it."""
    codes = sorted({finding.code for findings in reports.values() for finding in findings})
    rules = [{"id": code, "name": _pascal(code), "shortDescription": {"text": _words(code)}} for code in codes]
    results = [
        _result(path, finding, codes.index(finding.code), base)
        for path, findings in reports.items() for finding in findings
    ]  # fmt: skip
    driver = {"name": "Lucarna check", "semanticVersion": __version__, "rules": rules}
    run = {
        "tool": {"driver": driver},
        "originalUriBaseIds": {"ROOT": {"uri": base.absolute().as_uri().rstrip("/") + "/"}},
        "invocations": [{"executionSuccessful": True}],
        "columnKind": "unicodeCodePoints",
        "results": results,
    }
    return {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}


def _result(path: Path, finding: Finding, rule: int, base: Path) -> dict[str, Any]:
    file = Path(finding.where.file) if finding.where.file else path
    physical: dict[str, Any] = {"artifactLocation": _artifact(file, base)}
    if finding.where.line:
        physical["region"] = {"startLine": finding.where.line}
        if finding.where.column:
            physical["region"]["startColumn"] = finding.where.column
    location: dict[str, Any] = {"physicalLocation": physical}
    if finding.where.path:
        location["logicalLocations"] = [{"fullyQualifiedName": finding.where.path}]
    text = f"{finding.message}. {finding.hint[:1].upper()}{finding.hint[1:]}." if finding.hint else finding.message
    identity = f"{finding.code}\n{physical['artifactLocation']['uri']}\n{finding.where.path}\n{finding.message}"
    return {
        "ruleId": finding.code, "ruleIndex": rule, "level": LEVELS[finding.severity], "message": {"text": text},
        "locations": [location],
        "partialFingerprints": {"lucarna/v1": hashlib.blake2b(identity.encode("utf-8", "replace"),
                                                              digest_size=16).hexdigest()},
    }  # fmt: skip


def _artifact(file: Path, base: Path) -> dict[str, str]:
    absolute = file.absolute()
    try:
        return {"uri": quote(absolute.relative_to(base.absolute()).as_posix()), "uriBaseId": "ROOT"}
    except ValueError:
        return {"uri": absolute.as_uri()}


def _pascal(code: str) -> str:
    """`number.zero-area` -> `NumberZeroArea`."""
    return "".join(word[:1].upper() + word[1:] for word in code.replace(".", "-").split("-"))


def _words(code: str) -> str:
    return code.replace(".", ": ", 1).replace("-", " ")
