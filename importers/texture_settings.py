"""Settings of one image: `[textures."name.png"]` of a sidecar, over those of the whole source."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from engine.core.errors import UsageError
from importers.model import ImportedModel, SourceImage
from importers.settings import ImportSettings, did_you_mean

#: what may be said of one image
KEYS = ("role", "flip_green", "max_texture_size", "quality", "compress", "roughness_from_normals")


def names(key: str, image: SourceImage) -> bool:
    """Whether `key` names the image: its file, its name (with or without an extension), or its place in the source."""
    wanted, stem = key.lower(), Path(key).stem.lower()
    own = image.name.lower()
    return wanted in (Path(image.file).name.lower(), own, image.path.lower()) or (own != "" and stem == own)


def unmatched(model: ImportedModel, settings: ImportSettings) -> None:
    """A finding for every part of the tables `textures` and `materials` that names nothing in the source."""
    images = [image.name or image.path for image in model.images]
    materials = [material.asset.name for material in model.materials]
    for key in settings.textures:
        if model.lone is None and not any(names(key, image) for image in model.images):
            model.findings.warn("settings.unmatched", f"[textures.{key!r}] names no image of the source", "",
                                did_you_mean(key, dict.fromkeys(images)))  # fmt: skip
    for key in settings.materials:
        if key.lower() not in map(str.lower, materials):
            model.findings.warn("settings.unmatched", f"[materials.{key!r}] names no material of the source", "",
                                did_you_mean(key, dict.fromkeys(materials)))  # fmt: skip


def texture_settings(image: SourceImage, role: str, settings: ImportSettings) -> tuple[ImportSettings, str]:
    """(the settings to encode `image` with, the role to encode it for). Raises UsageError for unknown keys."""
    keys = [key for key in settings.textures if names(key, image)]
    said: Mapping[str, Any] = settings.table("textures", keys[0]) if keys else {}
    changes = dict(said)
    for key in changes:
        if key not in KEYS:
            known = dict.fromkeys(KEYS)
            raise UsageError(f"[textures.{image.name!r}] {key}: not for one image", hint=did_you_mean(key, known))
    wanted = str(changes.pop("role", role))
    # DirectX normal maps among others: the file's own name knows better than the setting for all of them
    if image.flip_green and "flip_green" not in changes:
        changes["flip_green"] = True
    own = settings.replace(**changes, textures={}, materials={}, role="auto")
    return own, role if wanted == "auto" else wanted
