"""ImportSettings: everything that changes what an import writes, and the limits that keep a hostile source harmless.

One declaration, many doors. A field made by `setting(...)` is at once

    a field          ImportSettings(max_texture_size=1024), checked: type, range, choices with did-you-mean
    a flag           `lucarna convert --max-texture-size 1024`, `--no-compress` for a bool that is True by default
    a sidecar key    `max_texture_size = 1024` in `fox.glb.import`, in a preset and in project.toml's [import]
    part of the key  of the cache and of `--explain`, if its group is one of OUTPUT_GROUPS

Adding one: a field here with its group, a doc line, and min, max or choices where they make sense; nothing else.
The type is that of the default: bool, int, float, str, tuple of str (a list in TOML, `a,b` as a flag), or dict (a
table in TOML, no flag) for what is said of single parts of a source, as `[textures."wood.png"]` with `role = "normal"`.
A reader asks `settings.table("textures", "wood.png")` for such a part.

Groups: `source` (how it is read), `geometry`, `animation`, `materials`, `textures` change the output. `limits` decide
whether a source loads, never what it becomes; `run` is how the work is done. Neither is part of `key()`.
`key("textures")` is the key of one group, for caches of one step. The values' origins are joined in importers.presets.

A new importer module registers by one `Importer` row in importers/registry.py; see there.
"""

from __future__ import annotations

import dataclasses
import difflib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from engine.core.errors import UsageError

#: Texture encoding effort, from quick looks to final assets. Each is also the name of a built-in preset.
QUALITIES = ("draft", "normal", "high", "final")
OUTPUT_GROUPS = ("source", "geometry", "animation", "materials", "textures")
GROUPS = (*OUTPUT_GROUPS, "limits", "run")

_KINDS: dict[type, str] = {bool: "bool", int: "int", float: "float", str: "str", tuple: "list", dict: "table"}
_WORDS = {
    "bool": "true or false", "int": "a whole number", "float": "a number", "str": "a text",
    "list": "a list of texts", "table": "a table",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Setting:
    """What is declared about one field. `kind`: bool, int, float, str, list or table."""

    name: str
    kind: str
    default: Any
    group: str
    doc: str
    min: float = -math.inf
    max: float = math.inf
    choices: tuple[str, ...] = ()
    unit: str = ""

    @property
    def flag(self) -> str:
        """`--max-texture-size`; '' where there is none."""
        return "" if self.kind == "table" else "--" + self.name.replace("_", "-")

    def check(self, value: Any) -> Any:
        """`value` in this setting's type and range. Raises UsageError, which names the setting."""
        if self.kind == "float" and type(value) is int:
            value = float(value)
        if self.kind == "list" and isinstance(value, list):
            value = tuple(value)
        fits = type(value) is type(self.default) or (self.kind == "table" and isinstance(value, Mapping))
        if not fits or (self.kind == "list" and not all(isinstance(item, str) for item in value)):
            raise UsageError(f"{self.name} is {value!r}", hint=f"give {_WORDS[self.kind]}")
        if self.kind in ("int", "float") and not self.min <= value <= self.max:
            span = f"{self.min:g} or more" if self.max == math.inf else f"{self.min:g} to {self.max:g}"
            raise UsageError(f"{self.name} is {value}", hint=f"give {span} {self.unit}".rstrip())
        for item in value if self.kind == "list" else [value]:
            if self.choices and item not in self.choices:
                near = difflib.get_close_matches(str(item), self.choices, 1)
                hint = f"did you mean {near[0]!r}?" if near else f"choose one of {', '.join(self.choices)}"
                raise UsageError(f"unknown {self.name} {item!r}", hint=hint)
        return value


def setting(
    default: Any, *, group: str, doc: str, min: float = -math.inf, max: float = math.inf,
    choices: tuple[str, ...] = (), unit: str = "",
) -> Any:  # fmt: skip
    """Declare a field of ImportSettings. `doc`: one line, shown by `--help`."""
    assert group in GROUPS, group
    about = {"group": group, "doc": doc, "min": min, "max": max, "choices": choices, "unit": unit}
    if isinstance(default, dict):
        return field(default_factory=dict, hash=False, metadata=about)
    return field(default=default, metadata=about)


@dataclass(frozen=True, slots=True)
class ImportSettings:
    """How a source becomes our files. The same source and settings give the same bytes. Raises UsageError."""

    allow_outside: bool = setting(False, group="source", doc="follow URIs that leave the source's folder")
    source_unit: float = setting(
        0.0, group="source", min=0.0, unit="metres",
        doc="how long one unit is in formats that do not say it (OBJ, STL, PLY …); 0 = a metre",
    )  # fmt: skip
    source_up: str = setting(
        "auto", group="source", choices=("auto", "y", "z"), doc="which axis is up in formats that do not say it"
    )
    scale: float = setting(
        1.0, group="source", min=1e-9, max=1e9, doc="make everything so many times as large, whatever the source says"
    )
    turn: str = setting(
        "none", group="source", choices=("none", "z-up", "z-down", "x-up", "y-down", "back", "left", "right"),
        doc="turn everything: what the source calls z becomes up, or what was front looks back, left, right",
    )  # fmt: skip
    scene: str = setting("", group="source", doc="which scene of a glTF file, by name or number; '' = its default one")
    image_as: str = setting(
        "auto", group="source", choices=("auto", "2d", "cube", "array", "environment"),
        doc="what a lone image becomes; auto knows six faces by name and HDR panoramas by shape",
    )  # fmt: skip
    clean_triangles: bool = setting(
        True, group="geometry", doc="leave out triangles that name a vertex twice or are there twice"
    )
    flip_v: bool = setting(False, group="geometry", doc="turn texture coordinates upside down")
    normals: str = setting(
        "keep", group="geometry", choices=("keep", "flat", "smooth"),
        doc="make normals anew: one a face, or smooth over edges of less than 60 degrees",
    )  # fmt: skip
    tangents: bool = setting(False, group="geometry", doc="make tangents anew from the first texture coordinates")
    triangle_order: str = setting(
        "overdraw", group="geometry", choices=("overdraw", "cache", "source"),
        doc="draw triangles as the vertex cache likes it, with overdraw also from the outside in; or as in the source",
    )  # fmt: skip
    quantize: bool = setting(
        False,
        group="geometry",
        doc="store positions, uvs and morph offsets in 16 bits of their box; the error is reported",
    )
    lods: int = setting(
        0, group="geometry", min=0, max=6, doc="simplified copies of each mesh, each half of the one before"
    )
    key_error_mm: float = setting(
        -1.0, group="animation", min=-1.0, unit="mm",
        doc="fewer keys in 16 bits while no vertex moves by more; 0 = all as they are, -1 = 1/10,000 of the size",
    )  # fmt: skip
    two_sided: bool = setting(False, group="materials", doc="draw both sides of every face")
    variant: str = setting("", group="materials", doc="material variant of a glTF file to show; '' = the plain ones")
    loose_textures: bool = setting(
        True, group="materials", doc="find textures beside the model by their names for materials without any"
    )
    materials: dict[str, Any] = setting(  # noqa: RUF009  (it makes a dataclass field)
        {}, group="materials", doc="by material: slot = image file, or false ([materials.steel] normal_map = 'n.png')"
    )
    quality: str = setting("normal", group="textures", choices=QUALITIES, doc="texture encoding effort")
    max_texture_size: int = setting(
        0, group="textures", min=0, unit="texels", doc="halve larger images until they fit; 0 = as they are"
    )
    compress: bool = setting(True, group="textures", doc="block-compress textures")
    role: str = setting(
        "auto", group="textures",
        choices=("auto", "color", "normal", "metal_rough", "data", "occlusion", "mask", "hdr"),
        doc="what a lone image holds; auto goes by the suffix of its name",
    )  # fmt: skip
    flip_green: bool = setting(False, group="textures", doc="normal maps have +Y down (DirectX): turn their green over")
    roughness_from_normals: bool = setting(
        False, group="textures", doc="rougher mips where the normal map's bumps are averaged away (Toksvig)"
    )
    textures: dict[str, Any] = setting(  # noqa: RUF009  (it makes a dataclass field)
        {}, group="textures", doc="by image file: role, flip_green, … ([textures.'n.png'] flip_green = true)"
    )
    max_file_bytes: int = setting(2 << 30, group="limits", min=1, unit="bytes", doc="refuse larger files")
    max_decoded_bytes: int = setting(
        2 << 30, group="limits", min=1, unit="bytes", doc="refuse a source that asks for more memory once decoded"
    )
    max_json_depth: int = setting(128, group="limits", min=1, doc="refuse JSON that is nested deeper")
    max_image_pixels: int = setting(16384 * 16384, group="limits", min=1, unit="pixels", doc="refuse larger images")
    max_worker_seconds: float = setting(
        300.0, group="limits", min=0.1, unit="seconds", doc="stop an import that takes longer"
    )
    max_worker_bytes: int = setting(
        8 << 30, group="limits", min=0, unit="bytes", doc="stop an import that wants more memory; 0 = no limit"
    )
    use_texture_cache: bool = setting(True, group="run", doc="reuse textures that were encoded before")
    jobs: int = setting(0, group="run", min=0, doc="texture threads of one import; 0 = one per core")

    def __post_init__(self) -> None:
        for info in declared().values():
            object.__setattr__(self, info.name, info.check(getattr(self, info.name)))

    def key(self, *groups: str) -> str:
        """A stable text of the settings that change the output (only those of `groups`, where given), for cache keys
        and provenance."""
        return json.dumps(self.output_values(*groups), sort_keys=True)

    def output_values(self, *groups: str) -> dict[str, Any]:
        """The values that `key` speaks of, by name."""
        wanted = groups or OUTPUT_GROUPS
        return {info.name: getattr(self, info.name) for info in declared().values() if info.group in wanted}

    def differences(self) -> dict[str, Any]:
        """What is not as by default, by name: JSON values."""
        values = {info.name: getattr(self, info.name) for info in declared().values()}
        return {name: value for name, value in values.items() if value != declared()[name].default}

    def table(self, name: str, part: str) -> Mapping[str, Any]:
        """What the table setting `name` says of `part` of the source; letter case does not matter. Empty if nothing."""
        entries: Mapping[str, Any] = getattr(self, name)
        found: Any = next((value for key, value in entries.items() if key.lower() == part.lower()), {})
        return found if isinstance(found, Mapping) else {}

    def replace(self, **changes: object) -> ImportSettings:
        """A copy with `changes`; raises UsageError as the constructor does, and for unknown names."""
        for name in changes:
            if name not in declared():
                raise UsageError(f"unknown setting {name!r}", hint=did_you_mean(name, declared()))
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]  # the constructor checks the values


_declared: dict[str, Setting] = {}


def declared() -> dict[str, Setting]:
    """All settings by name, in the order of their declaration."""
    if not _declared:
        for entry in dataclasses.fields(ImportSettings):
            default = {} if entry.default is dataclasses.MISSING else entry.default
            _declared[entry.name] = Setting(entry.name, _KINDS[type(default)], default, **entry.metadata)
    return _declared


def did_you_mean(name: str, known: Mapping[str, object]) -> str:
    """A hint for a mistyped name."""
    near = difflib.get_close_matches(name, known, 1)
    return f"did you mean {near[0]!r}?" if near else f"known: {', '.join(known)}"
