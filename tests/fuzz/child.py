"""The child: reads one order a line, converts or checks what it names, answers in one line."""

from __future__ import annotations

import json
import os
import sys
import threading
import time
import traceback
from pathlib import Path

from engine.core.errors import LucarnaError
from importers.settings import ImportSettings

SETTINGS = ImportSettings(
    max_worker_seconds=15.0, max_worker_bytes=2 << 30, max_decoded_bytes=256 << 20, max_file_bytes=256 << 20
)
MEMORY = 6 << 30


def do(order: dict[str, str]) -> dict[str, object]:
    """{"outcome": imported, findings, refused or traceback, "message"}."""
    path, out = Path(order["path"]), Path(order["out"])
    if order["what"] == "vanishing":
        threading.Timer(float(order["delay"]), lambda: Path(order["target"]).unlink(missing_ok=True)).start()
    _outside.clear()
    try:
        findings = _WORK[order["work"]](path, out)
    except LucarnaError as error:
        return {"outcome": "refused", "message": f"{type(error).__name__}: {error}"}
    except MemoryError:
        return {"outcome": "memory", "message": traceback.format_exc(limit=-3)}
    except BaseException:  # the very thing that is looked for
        return {"outcome": "traceback", "message": traceback.format_exc(limit=-6)}
    if _outside and order["work"] == "convert":  # files of ours may name what lies beside their folder
        return {"outcome": "read outside", "message": ", ".join(_outside)}
    return {"outcome": "findings" if findings else "imported", "message": ""}


def _watch(event: str, arguments: tuple[object, ...]) -> None:
    """An audit hook: files that no import may open."""
    if event == "open" and str(arguments[0]).endswith(("/secret.png", "/etc/passwd", "/.ssh/id")):
        _outside.append(str(arguments[0]))


_outside: list[str] = []


def _convert(path: Path, out: Path) -> bool:
    from engine.assets.scene_json import read_scene
    from importers.checks.files import check_file
    from importers.convert import convert

    result = convert(path, out, SETTINGS)
    # what was written must be readable
    assert result.scene is not None
    for file in result.outputs:
        if file.suffix != ".json":
            check_file(file, SETTINGS)
    read_scene(result.scene)
    return result.findings.has_errors


def _check(path: Path, out: Path) -> bool:
    from importers.checks.files import check_file

    return check_file(path, SETTINGS).has_errors


def _image(path: Path, out: Path) -> bool:
    from importers.gltf.uris import read_regular_file
    from importers.textures.encode import encode
    from importers.textures.image import decode

    pixels = decode(read_regular_file(path, SETTINGS.max_file_bytes), path.name, SETTINGS)
    if pixels.size < 1 << 22:
        encode(pixels, "hdr" if pixels.dtype.kind == "f" else "color", SETTINGS)
    return False


_WORK = {"convert": _convert, "check": _check, "image": _image}


def main() -> None:
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, resource.getrlimit(resource.RLIMIT_AS)[1]))
    except (ImportError, ValueError, OSError):
        pass
    sys.addaudithook(_watch)
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a library prints is no answer
    for line in sys.stdin:
        clock = time.perf_counter()
        answer = do(json.loads(line))
        answers.write(json.dumps(answer | {"seconds": time.perf_counter() - clock}) + "\n")
        answers.flush()


if __name__ == "__main__":
    main()
