"""URIs of a glTF file: data: URIs are decoded, relative ones resolved, and neither may leave the asset's folder."""

from __future__ import annotations

import base64
import binascii
import difflib
import os
import re
import stat
from pathlib import Path
from urllib.parse import unquote, unquote_to_bytes

from engine.core.errors import InputError

_SCHEME = re.compile(r"^[A-Za-z][A-Za-z0-9+.\-]*:")


def decode_data_uri(uri: str) -> bytes:
    """The bytes of a `data:` URI (RFC 2397), base64 or percent-encoded. Raises InputError."""
    head, comma, body = uri[len("data:") :].partition(",")
    if not comma:
        raise InputError("the data: URI has no comma, so no data")
    if not head.endswith(";base64"):
        return unquote_to_bytes(body)
    text = unquote(body) if "%" in body else body
    try:
        return base64.b64decode(text + "=" * (-len(text) % 4), validate=True)
    except (binascii.Error, ValueError) as error:
        raise InputError(f"the data: URI is no valid base64: {error}", hint="export the file again") from error


def resolve_uri(uri: str, root: Path, allow_outside: bool = False) -> Path:
    """The file that a relative URI (RFC 3986, percent-encoded) names; `root` is the asset's folder.

    Raises InputError where the URI has a scheme, is absolute, or leads out of `root` (by `..`, encoded or not, or
    by a symbolic link), unless `allow_outside`.
    """
    uri = storable_text(uri)
    if _SCHEME.match(uri) and not re.match(r"^[A-Za-z]:[\\/]", uri):
        raise InputError(
            f"refused: {_shorten(uri)!r} is no file beside the source", hint="only relative and data: URIs are read"
        )
    name = unquote(uri.split("?", 1)[0].split("#", 1)[0]) if "%" in uri else uri
    if not name or "\0" in name:
        raise InputError("the URI is empty" if not name else "the URI holds a zero byte")
    candidate = root / name
    if "\\" in name and not os.path.lexists(candidate):
        name = name.replace("\\", "/")
        candidate = root / name
    inside = root.resolve()
    try:
        resolved = candidate.resolve()
    except (OSError, RuntimeError) as error:
        raise InputError(f"{_shorten(name)!r} cannot be resolved: {error}") from error
    if not allow_outside and (name.startswith("/") or not resolved.is_relative_to(inside)):
        raise InputError(
            f"refused: {_shorten(uri)!r} leads out of the asset's folder",
            hint="copy the file into the folder, or pass --allow-outside if you trust the source",
        )
    return resolved


def read_regular_file(path: Path, max_bytes: int) -> bytes:
    """The bytes of a regular file of at most `max_bytes`. Raises InputError: no pipes, devices, folders or giants."""
    try:
        status = path.stat()
        if stat.S_ISDIR(status.st_mode):
            raise InputError("is a folder, not a file", where=path)
        if not stat.S_ISREG(status.st_mode):
            raise InputError("is not a regular file", where=path, hint="pipes and devices are not read")
        if status.st_size > max_bytes:
            raise InputError(f"has {status.st_size:,} bytes; the limit is {max_bytes:,}", where=path)
        return path.read_bytes()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise InputError(f"cannot read: {reason}", where=path, hint=similar_name_hint(path)) from error


def similar_name_hint(path: Path) -> str:
    """What to do about a missing file: name the file beside it that is spelt alike, if there is one."""
    try:
        names = sorted(p.name for p in path.parent.iterdir())
    except OSError:
        return "check that the path is right"
    names = [n for n in names if Path(n).suffix.lower() == path.suffix.lower()]
    if path.name in names:
        return "check that you may read it"
    near = difflib.get_close_matches(path.name.lower(), [n.lower() for n in names], 1, 0.6)
    if not near:
        return "put the file there, or export the source again"
    return f"did you mean {next(n for n in names if n.lower() == near[0])!r}?"


def storable_text(text: str) -> str:
    """`text` with halves of surrogate pairs, which JSON allows and UTF-8 does not, replaced by `?`."""
    return text.encode("utf-8", "replace").decode("utf-8")


def _shorten(text: str) -> str:
    return text if len(text) <= 120 else f"{text[:100]}…"
