"""Which of the four Ogre files this is, and its reader."""

from __future__ import annotations

from pathlib import Path

from engine.core.errors import FormatError, InputError
from engine.core.findings import Findings
from importers.gltf.uris import read_regular_file
from importers.ogre.data import OgreMesh, OgreSkeleton
from importers.ogre.sniff import BINARY, xml_root
from importers.settings import ImportSettings

#: bytes of memory for each byte of XML, roughly
_XML_GROWTH = 8


def read_source(path: Path, settings: ImportSettings, findings: Findings) -> OgreMesh | OgreSkeleton:
    """The mesh or skeleton in the file, told by its content. Raises InputError, FormatError."""
    data = read_regular_file(path, settings.max_file_bytes)
    file = str(path)
    if data.startswith(BINARY):
        if data[2:13] == b"[Serializer":
            from importers.ogre.skeleton_binary import read_skeleton

            return read_skeleton(data, file, findings)
        from importers.ogre.mesh_binary import read_mesh

        return read_mesh(data, file, findings)
    root = xml_root(data[:4096])
    if root in ("mesh", "skeleton") and len(data) > settings.max_decoded_bytes // _XML_GROWTH:
        raise InputError(
            f"has {len(data):,} bytes of XML; the limit is {settings.max_decoded_bytes // _XML_GROWTH:,}", where=path,
            hint="make it binary with OgreXMLConverter, or raise max_decoded_bytes",
        )  # fmt: skip
    if root == "mesh":
        from importers.ogre.mesh_xml import read_mesh_xml

        return read_mesh_xml(data, file, findings)
    if root == "skeleton":
        from importers.ogre.skeleton_xml import read_skeleton_xml

        return read_skeleton_xml(data, file, findings)
    if not data:
        raise FormatError("the file is empty", where=path, hint="export it again")
    raise FormatError(
        "is no Ogre mesh or skeleton: it begins neither with their header nor with <mesh> or <skeleton>", where=path,
        hint="is the extension right?",
    )  # fmt: skip
