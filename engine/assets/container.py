"""The safetensors container of .lmesh and .lanim: named arrays and a JSON header, mapped not copied.

    u8 header length | JSON {name: {dtype, shape, data_offsets}, "__metadata__": {"lucarna": JSON}} | arrays

Written here rather than by the library because the bytes must be the same each time and the arrays aligned to 64
bytes; the gaps are arrays of their own (`~pad0` …), so any safetensors reader opens the files.
Format: the safetensors specification (Hugging Face, 2022).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from engine.assets.mapping import map_file
from engine.core.atomic import atomic_path
from engine.core.errors import FormatError, Place

ALIGNMENT = 64
MAX_HEADER = 64 << 20
METADATA_KEY = "lucarna"

_DTYPES = {
    "F64": "<f8", "F32": "<f4", "F16": "<f2", "I64": "<i8", "U64": "<u8", "I32": "<i4", "U32": "<u4",
    "I16": "<i2", "U16": "<u2", "I8": "|i1", "U8": "|u1", "BOOL": "|b1",
}  # fmt: skip
_CODES = {np.dtype(text): code for code, text in _DTYPES.items()}

Arrays = dict[str, NDArray[np.generic]]


def write_container(path: Path, metadata: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write `arrays` in their order with `metadata` (any JSON) beside them; atomic, same bytes for the same input.

    Raises OutputError.
    """
    header: dict[str, Any] = {"__metadata__": {METADATA_KEY: compact_json(metadata)}}
    blocks: list[NDArray[Any]] = []
    offset = 0
    for name, array in arrays.items():
        block = np.ascontiguousarray(array)
        block = block.astype(block.dtype.newbyteorder("<"), copy=False)
        gap = -offset % ALIGNMENT
        if gap:
            header[f"~pad{len(blocks)}"] = {"dtype": "U8", "shape": [gap], "data_offsets": [offset, offset + gap]}
            blocks.append(np.zeros(gap, np.uint8))
            offset += gap
        end = offset + block.nbytes
        header[name] = {
            "dtype": _CODES[block.dtype],
            "shape": list(np.shape(array)),
            "data_offsets": [offset, end],
        }
        blocks.append(block)
        offset = end
    text = json.dumps(header, separators=(",", ":"), ensure_ascii=False).encode("utf-8")
    text += b" " * (-(8 + len(text)) % ALIGNMENT)
    with atomic_path(Path(path)) as temporary, temporary.open("wb") as file:
        file.write(len(text).to_bytes(8, "little"))
        file.write(text)
        for block in blocks:
            if block.nbytes:
                file.write(block.reshape(-1).view(np.uint8).data)


def read_container(path: Path, schema: str, *older: str) -> tuple[dict[str, Any], Arrays]:
    """The metadata and the arrays (read-only views of the mapped file).

    Checks the header, that every array lies inside the file with the size its shape and dtype say, and that the
    metadata's `schema` is `schema` or one of the `older`. Raises InputError, FormatError.
    """
    data = map_file(path)
    where = str(path)
    if len(data) < 8:
        raise FormatError(f"has {len(data)} bytes, too few for a header", where=where)
    length = int.from_bytes(data[:8], "little")
    if not 2 <= length <= min(MAX_HEADER, len(data) - 8):
        raise FormatError(f"header length {length} does not fit the file's {len(data)} bytes", where=where)
    try:
        header = json.loads(bytes(data[8 : 8 + length]))
        raw = header["__metadata__"][METADATA_KEY]
        metadata = json.loads(raw) if isinstance(raw, str) else None
    except (ValueError, RecursionError, KeyError, TypeError) as error:
        raise FormatError(f"the header is not that of a Lucarna file: {error}", where=where) from error
    found = metadata.get("schema") if isinstance(metadata, dict) else None
    if not isinstance(metadata, dict) or found not in (schema, *older):
        raise FormatError(f"schema is {found!r}, expected {schema!r}", where=where, hint="convert the source again")
    body = np.frombuffer(data, np.uint8, offset=8 + length)
    arrays: Arrays = {}
    for name, entry in header.items():
        if name != "__metadata__" and not name.startswith("~pad"):
            arrays[name] = _array(name, entry, body, where)
    return metadata, arrays


def _array(name: str, entry: Any, body: NDArray[np.uint8], where: str) -> NDArray[np.generic]:
    place = Place(where, path=name)
    try:
        dtype = np.dtype(_DTYPES[entry["dtype"]])
        shape = [natural(n) for n in entry["shape"]]
        start, end = (natural(n) for n in entry["data_offsets"])
    except (KeyError, TypeError, ValueError) as error:
        raise FormatError(f"bad array entry: {error}", where=place) from error
    size = math.prod(shape) * dtype.itemsize
    if len(shape) > 8 or end - start != size or end > len(body):
        raise FormatError(
            f"bytes {start}..{end} of {len(body)} do not hold {dtype} of shape {shape} ({size} bytes)", where=place
        )
    view = body[start:end]
    if size and (view.__array_interface__["data"][0] % dtype.itemsize):
        view = view.copy()  # written by other tools without alignment
    return cast("NDArray[np.generic]", view.view(dtype).reshape(shape))


def natural(value: Any) -> int:
    """`value` when it is an int >= 0; raises ValueError."""
    if type(value) is not int or value < 0:
        raise ValueError(f"{value!r} is not a count")
    return value


def compact_json(value: Any) -> str:
    """Deterministic JSON: keys sorted, no spaces, shortest floats, no NaN (ValueError)."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False, default=plain)


def plain(value: Any) -> Any:
    """numpy scalars and arrays as Python's own numbers and lists, for json."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be stored as JSON")
