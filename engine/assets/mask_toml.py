"""`*.mask.toml`: a bone mask by itself, to be used by several animations.

schema = "lucarna.mask/1"
name = "upper body"
subtrees = [{ node = "spine", fall_off = 2 }]
nodes = { "left hand" = 0.0 }
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import tomlkit
from pydantic import ConfigDict, Field, ValidationError

from engine.assets.animation_toml import MaskModel, Name
from engine.core.atomic import write_text
from engine.core.toml_source import load_toml

SCHEMA = "lucarna.mask/1"


class _MaskFile(MaskModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)
    schema_: Literal["lucarna.mask/1"] = Field(alias="schema")
    name: Name


def read_mask(path: Path) -> tuple[str, MaskModel]:
    """The name and the mask. Raises InputError when it cannot be read, FormatError at the line of what is wrong."""
    source = load_toml(path)
    try:
        model = _MaskFile.model_validate(source.data)
    except ValidationError as error:
        first = error.errors()[0]
        place = tuple("schema" if p == "schema_" else p for p in first["loc"] if p != "[key]")
        raise source.error(
            place, str(first["msg"]), value=first["type"] not in ("missing", "extra_forbidden")
        ) from None
    return model.name, MaskModel(subtrees=model.subtrees, nodes=model.nodes)


def write_mask(path: Path, name: str, mask: MaskModel) -> None:
    """Write it, whole or not at all. Raises OutputError."""
    data: dict[str, Any] = {"schema": SCHEMA, "name": name, **mask.model_dump(exclude_defaults=True)}
    write_text(path, tomlkit.dumps(data))
