"""The container: a .gltf or .glb file becomes a JSON tree and its buffers' bytes.

Source: glTF 2.0 specification (Khronos, 2021), section 3.6 (buffers, URIs) and 4 (GLB).
"""

from __future__ import annotations

import json
import re
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from engine.core.errors import FormatError, InputError, Place
from engine.core.findings import Findings
from importers.gltf.uris import decode_data_uri, read_regular_file, resolve_uri
from importers.settings import ImportSettings

MAGIC = b"glTF"
_CHUNK_JSON = 0x4E4F534A
_CHUNK_BIN = 0x004E4942
#: a string, closed or not: that an open one matches too keeps the search linear on hostile input
_STRING = re.compile(rb'"[^"\\]*(?:\\.[^"\\]*)*"?', re.DOTALL)


@dataclass(slots=True)
class Container:
    """`root`: the JSON object. `binary`: the GLB's own chunk. `folder`: where relative URIs start."""

    path: Path
    folder: Path
    root: dict[str, Any]
    binary: memoryview | None
    settings: ImportSettings
    dependencies: list[Path] = field(default_factory=list)

    def read_uri(self, uri: str) -> bytes:
        """The bytes behind a URI; raises InputError. Files read are noted as dependencies."""
        if uri.startswith("data:"):
            return decode_data_uri(uri)
        path = resolve_uri(uri, self.folder, self.settings.allow_outside)
        if path not in self.dependencies:
            self.dependencies.append(path)
        return read_regular_file(path, self.settings.max_file_bytes)


def read_container(path: Path, settings: ImportSettings, findings: Findings) -> Container:
    """Read a .gltf or .glb. Raises FormatError or InputError where nothing at all can be had from it.

    A GLB cut within its binary chunk still yields a container, and an error finding.
    """
    data = memoryview(read_regular_file(path, settings.max_file_bytes))
    binary: memoryview | None = None
    if bytes(data[:4]) == MAGIC:
        text, binary = _split_glb(data, path, findings)
    else:
        text = data
        start = bytes(data[:4096]).removeprefix(b"\xef\xbb\xbf").lstrip()
        if not start.startswith(b"{"):
            what = f"starts with {start[:8]!r}" if start else "is empty"
            raise FormatError(
                f"is no glTF: it {what}, expected 'glTF' or '{{'", where=path, hint="copy or export it again"
            )
    root = parse_json(bytes(text), path, settings.max_json_depth, findings)
    return Container(path, path.parent, root, binary, settings)


def _split_glb(data: memoryview, path: Path, findings: Findings) -> tuple[memoryview, memoryview | None]:
    if len(data) < 20:
        raise FormatError(
            f"the GLB ends after {len(data)} bytes, within its header", where=path, hint="copy or export it again"
        )
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise FormatError(f"GLB version {version}; only version 2 is known", where=path, hint="export it as glTF 2.0")
    if length > len(data):
        findings.error(
            "glb.truncated", f"the header says {length:,} bytes, the file has {len(data):,}: it is cut off",
            "GLB header", "copy or export it again; what the rest held is missing",
        )  # fmt: skip
    elif length < len(data):
        findings.warn("glb.trailing", f"{len(data) - length:,} bytes follow the end that it gives", "GLB header")
        data = data[: max(length, 20)]
    text: memoryview | None = None
    binary: memoryview | None = None
    offset, number = 12, 0
    while offset + 8 <= len(data):
        size, kind = struct.unpack_from("<II", data, offset)
        chunk = data[offset + 8 : offset + 8 + size]
        place = f"GLB chunk {number} at byte {offset}"
        if len(chunk) < size:
            if number == 0:
                raise FormatError(
                    f"the JSON chunk should have {size:,} bytes, {len(chunk):,} are there",
                    where=Place(str(path), path=place), hint="copy or export it again",
                )  # fmt: skip
            findings.error(
                "glb.truncated", f"the chunk should have {size:,} bytes, {len(chunk):,} are there", place,
                "copy or export it again; what the rest held is missing",
            )  # fmt: skip
        if number == 0:
            if kind != _CHUNK_JSON:
                raise FormatError(
                    f"the first chunk has type 0x{kind:08X}, not JSON", where=Place(str(path), path=place)
                )
            text = chunk
        elif kind == _CHUNK_BIN and binary is None:
            binary = chunk
        offset += 8 + size + (-size % 4)
        number += 1
    if text is None:
        raise FormatError("the GLB holds no JSON chunk", where=path, hint="copy or export it again")
    return text, binary


def parse_json(text: bytes, path: Path, max_depth: int, findings: Findings) -> dict[str, Any]:
    """The JSON object of a glTF file. The depth is measured before parsing. Raises FormatError with line and column."""
    depth = json_depth(text, max_depth)
    if depth > max_depth:
        raise FormatError(
            f"the JSON nests {depth:,} levels deep; the limit is {max_depth}",
            where=path, hint="a real glTF file needs about ten",
        )  # fmt: skip
    if text.startswith(b"\xef\xbb\xbf"):
        findings.warn("gltf.bom", "the JSON starts with a byte order mark, which glTF forbids", hint="export it again")
        text = text[3:]
    try:
        root = json.loads(text.decode("utf-8"))
    except UnicodeDecodeError as error:
        line = text.count(b"\n", 0, error.start) + 1
        column = error.start - (text.rfind(b"\n", 0, error.start) + 1) + 1
        raise FormatError("the JSON is not valid UTF-8", where=Place(str(path), line, column)) from error
    except json.JSONDecodeError as error:
        raise FormatError(
            f"the JSON is broken: {error.msg}", where=Place(str(path), error.lineno, error.colno),
            hint="copy or export it again",
        ) from error  # fmt: skip
    except (ValueError, RecursionError) as error:
        raise FormatError(f"the JSON cannot be read: {error}", where=path) from error
    if not isinstance(root, dict):
        raise FormatError("the JSON is no object, so this is no glTF file", where=path)
    _check_version(root, path, findings)
    return root


def json_depth(text: bytes, stop: int) -> int:
    """The depth of nesting of a JSON text, without parsing it; 0 where it has too few brackets to pass `stop`."""
    if text.count(b"[") + text.count(b"{") <= stop:
        return 0
    characters = np.frombuffer(_STRING.sub(b"", text), np.uint8)
    brackets = characters[np.isin(characters, np.frombuffer(b"[{]}", np.uint8))]
    steps = np.where(np.isin(brackets, np.frombuffer(b"[{", np.uint8)), 1, -1)
    return int(np.cumsum(steps).max(initial=0))


def _check_version(root: dict[str, Any], path: Path, findings: Findings) -> None:
    asset = root.get("asset")
    version = asset.get("version") if isinstance(asset, dict) else None
    if version is None:
        findings.warn("gltf.no-version", "the file does not say its glTF version; read as 2.0", "asset.version")
        return
    minimum = asset.get("minVersion", "2.0") if isinstance(asset, dict) else "2.0"
    for key, value in (("version", version), ("minVersion", minimum)):
        major = re.match(r"(\d+)\.(\d+)$", str(value)[:20])
        newer = key == "minVersion" and major is not None and int(major[2]) > 0
        if major is None or int(major[1]) != 2 or newer:
            raise FormatError(
                f"glTF version {value!r}; only 2.0 is known", where=Place(str(path), path=f"asset.{key}"),
                hint="export it as glTF 2.0",
            )  # fmt: skip


class Buffers:
    """The bytes of `buffers[i]`, fetched when first asked for; None (and one finding) where they are not to be had."""

    def __init__(self, container: Container, buffers: list[dict[str, Any]], findings: Findings) -> None:
        self._container = container
        self._objects = buffers
        self._findings = findings
        self._cache: dict[int, memoryview | None] = {}

    def get(self, index: int) -> memoryview | None:
        if index not in self._cache:
            self._cache[index] = self._load(index)
        return self._cache[index]

    def _load(self, index: int) -> memoryview | None:
        where = f"buffers[{index}]"
        uri = self._objects[index].get("uri")
        if uri is None:
            if index == 0 and self._container.binary is not None:
                data = self._container.binary
            else:
                self._findings.error("gltf.buffer", "the buffer has no uri and the file no binary chunk for it", where)
                return None
        elif not isinstance(uri, str):
            self._findings.error("gltf.type", "expected a string", f"{where}.uri")
            return None
        else:
            try:
                data = memoryview(self._container.read_uri(uri))
            except InputError as error:
                self._findings.error(
                    "gltf.buffer", _one_line(error), f"{where}.uri", error.hint or "what it holds is missing"
                )
                return None
        expected = self._objects[index].get("byteLength")
        if not isinstance(expected, int) or isinstance(expected, bool) or expected < 1:
            self._findings.error("gltf.value", f"the byte length is {expected!r}", f"{where}.byteLength")
        elif expected > len(data):
            self._findings.error(
                "gltf.buffer-short", f"the buffer should have {expected:,} bytes, {len(data):,} are there", where,
                "copy or export it again; what the rest held is missing",
            )  # fmt: skip
        return data


def _one_line(error: InputError) -> str:
    place = str(error.where)
    return f"{place}: {error.message}" if place else error.message
