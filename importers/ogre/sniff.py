"""Telling Ogre files by their first bytes. Imports nothing, so that every command can afford it."""

from __future__ import annotations

#: the header chunk's id, little and big endian
BINARY = (b"\x00\x10", b"\x10\x00")


def is_ogre(head: bytes) -> bool:
    """Whether a file that begins with `head` is an Ogre mesh or skeleton, binary or XML."""
    if head.startswith(BINARY):
        return head[2:17] == b"[MeshSerializer" or head[2:13] == b"[Serializer"
    return xml_root(head) in ("mesh", "skeleton")


def xml_root(head: bytes) -> str:
    """The name of the first element of an XML file, or ''."""
    text = head.lstrip(b"\xef\xbb\xbf \t\r\n")
    while text.startswith((b"<?", b"<!--")):
        end = b"?>" if text.startswith(b"<?") else b"-->"
        _, found, text = text.partition(end)
        if not found:
            return ""
        text = text.lstrip()
    if not text.startswith(b"<"):
        return ""
    name = text[1:80].split(b">")[0].split(b"/")[0].split()
    return name[0].decode("ascii", "replace") if name else ""
