"""KHR_draco_mesh_compression: a primitive's attributes and indices out of a Draco stream.

Source: KHR_draco_mesh_compression (Khronos, 2018). The decoder is Google's, through DracoPy (the extra `gltf`): native
code, so it is run where the whole import is, in a worker process.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from importers.gltf.accessors import Accessors
from importers.gltf.document import Document, JsonObject

NAME = "KHR_draco_mesh_compression"
MISSING = "install the decoder: pip install 'lucarna[gltf]', or export without Draco compression"


def decoder() -> Callable[[bytes], Any] | None:
    """The decoding function, or None where the library is not installed."""
    try:
        import DracoPy  # 8 MB of native code, for Draco files only
    except ImportError:
        return None
    decode: Callable[[bytes], Any] = DracoPy.decode
    return decode


def read_draco(doc: Document, accessors: Accessors, primitive: JsonObject, where: str) -> bool:
    """Decode the primitive's stream into the accessors it names; False (with a finding) where that cannot be done."""
    place = f"{where}.extensions.{NAME}"
    extension = doc.extension(primitive, NAME, where) or {}
    decode = decoder()
    if decode is None:
        doc.findings.error(
            "gltf.draco", f"the primitive is compressed by {NAME}, whose decoder is missing", place, MISSING
        )
        return False
    view = doc.integer(extension, "bufferView", place)
    data = None if view is None else accessors.view_bytes(view, f"{place}.bufferView")
    if data is None:
        doc.findings.error("gltf.draco", "the compressed data is not to be had", place)
        return False
    try:
        mesh = decode(bytes(data))
        found = {int(a["unique_id"]): np.asarray(a["data"]) for a in mesh.attributes}
        faces = getattr(mesh, "faces", None)
        triangles = None if faces is None else np.asarray(faces)
    except Exception as error:  # the binding raises classes of its own, and RuntimeError
        doc.findings.error("gltf.draco", f"the compressed data is damaged: {error}", place, "export the mesh again")
        return False
    attributes = doc.child(primitive, "attributes", where)
    streams = doc.child(extension, "attributes", place)
    for semantic in streams:
        number = doc.integer(streams, semantic, f"{place}.attributes")
        index = doc.index(attributes, semantic, f"{where}.attributes", "accessors")
        values = None if number is None else found.get(number)
        if values is None or index is None:
            doc.findings.error("gltf.draco", f"the stream has no attribute {number} for {semantic[:60]!r}", place)
            continue
        _give(doc, accessors, index, values, f"{place}.attributes")
    if "indices" in primitive and triangles is not None:
        index = doc.index(primitive, "indices", where, "accessors")
        if index is not None:
            _give(doc, accessors, index, triangles.reshape(-1, 1).astype("<u4"), f"{where}.indices")
    return True


def _give(doc: Document, accessors: Accessors, index: int, values: NDArray[Any], where: str) -> None:
    values = values.reshape(len(values), -1)
    if accessors.count(index) != len(values):
        doc.findings.warn(
            "gltf.draco",
            f"accessors[{index}] has a count of {accessors.count(index):,}, the stream {len(values):,}",
            where,
        )
    accessors.provide(index, values)
