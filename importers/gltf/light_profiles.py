"""Lights that IES files shape: the extension EXT_lights_ies (NVIDIA and PTC, 2023).

Its light points along the node's -Z with horizontal angle 0 in the XZ plane, as ours does; the file's candela count as
they are, times `multiplier`.
"""

from __future__ import annotations

from pathlib import PurePosixPath
from typing import TYPE_CHECKING
from urllib.parse import unquote

from engine.assets.ies import parse_ies
from engine.assets.scene import LightAsset
from engine.core.errors import InputError
from importers.gltf.document import Document, JsonObject
from importers.model import ImportedModel

if TYPE_CHECKING:
    from importers.gltf.accessors import Accessors
    from importers.gltf.container import Container

PROFILES = "EXT_lights_ies"
_ROOT = f"extensions.{PROFILES}"


def profile_entries(doc: Document) -> list[JsonObject]:
    """The profiles that the file defines."""
    holder = doc.extension(doc.root, PROFILES, "") or {}
    return doc.child_objects(holder, "lights", _ROOT)


def profiled_light(doc: Document, reference: JsonObject, where: str) -> LightAsset | None:
    """The light of a node; its profile is a number until `read_profiles`, its intensity the multiplier."""
    place, count = f"{where}.extensions.{PROFILES}", len(profile_entries(doc))
    number = doc.integer(reference, "light", place)
    if number is None or not 0 <= number < count:
        doc.findings.error("gltf.index", f"light profile {number} does not exist; the file has {count}", place)
        return None
    r, g, b = doc.vector(reference, "color", place, (1.0, 1.0, 1.0))
    color = (min(max(r, 0.0), 1.0), min(max(g, 0.0), 1.0), min(max(b, 0.0), 1.0))
    multiplier = doc.number(reference, "multiplier", place, 1.0, 0.0, 3e38)
    return LightAsset("point", color, multiplier, profile=f"#{number}")


def read_profiles(doc: Document, container: Container, accessors: Accessors, model: ImportedModel) -> None:
    """Fetch the profiles that nodes name into `model.profiles` and give the lights their candela."""
    found: dict[str, tuple[str, float]] = {}
    for node in model.nodes:
        if node.light is None or not node.light.profile.startswith("#"):
            continue
        if node.light.profile not in found:
            found[node.light.profile] = _fetch(doc, container, accessors, model, int(node.light.profile[1:]))
        node.light.profile, peak = found[node.light.profile]
        node.light.intensity *= peak


def _fetch(
    doc: Document, container: Container, accessors: Accessors, model: ImportedModel, number: int
) -> tuple[str, float]:
    """The name of a profile in `model.profiles` and its candela; "" and 1 where it is not to be had."""
    entry, where = profile_entries(doc)[number], f"{_ROOT}.lights[{number}]"
    uri = doc.text(entry, "uri", where)
    try:
        if uri:
            data = container.read_uri(uri)
        else:
            view = doc.integer(entry, "bufferView", where)
            seen = None if view is None else accessors.view_bytes(view, f"{where}.bufferView")
            if seen is None:
                raise InputError("the light profile has no bytes")
            data = bytes(seen)
        profile = parse_ies(data.decode("latin-1"), where, doc.findings)
    except InputError as error:
        doc.findings.error("gltf.light", str(error), where, "the light shines evenly without its profile")
        return "", 1.0
    stem = "" if uri.startswith("data:") else PurePosixPath(unquote(uri).replace("\\", "/")).stem
    name = f"{doc.name(entry, where, stem or f'profile {number}')}.ies"
    while name in model.profiles:
        name = f"{name.removesuffix('.ies')} {number}.ies"
    model.profiles[name] = data
    return name, profile.peak
