"""A report on disk: report.html and report.json, both or neither half; and reading the twin back."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from engine.core.atomic import write_text
from engine.core.errors import FormatError, InputError
from engine.report.page.html import page
from engine.report.records import Report
from engine.report.twin_form import check_twin

#: a twin is text about a few hundred points; anything larger is none
MAX_BYTES = 64 << 20


def write_report(report: Report, folder: Path) -> tuple[Path, Path]:
    """Write `folder`/report.html and report.json; returns both paths. Raises OutputError."""
    text = page(report)
    twin = json.dumps(report.to_json(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    html_path, json_path = folder / "report.html", folder / "report.json"
    write_text(html_path, text)
    write_text(json_path, twin)
    return html_path, json_path


def load_twin(path: Path) -> dict[str, Any]:
    """Read a report.json. Raises InputError, FormatError."""
    try:
        if path.stat().st_size > MAX_BYTES:
            raise FormatError(f"larger than {MAX_BYTES >> 20} MiB: no report", where=path)
        data = json.loads(path.read_text("utf-8"))
    except OSError as error:
        raise InputError(f"cannot read: {error.strerror or error}", where=path) from error
    except (ValueError, RecursionError) as error:
        raise FormatError(f"no JSON: {error}", where=path, hint="give a report.json of `lucarna report`") from error
    check_twin(data, path)
    assert isinstance(data, dict)
    return data
