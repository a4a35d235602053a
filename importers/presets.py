"""Where the settings of one source come from. Later rows win:

    1  the defaults                       importers/settings.py
    2  project.toml   [import]            for every source below the project's folder
    3  a preset                           named by --preset, else by the sidecar, else by [import]
    4  name.ext.import  beside the source what this one file wants otherwise
    5  flags                              what was said on the command line

    # fox.glb.import                      # project.toml                     # presets/mobile.toml
    preset = "mobile"                     [import]                           max_texture_size = 512
    max_texture_size = 1024               preset = "mobile"                  quality = "draft"
    [textures."skin.png"]                 [presets.stage]
    role = "normal"                       quality = "high"

Presets: the built-in ones (a texture quality each), `[presets.NAME]` of project.toml, `presets/NAME.toml` beside it, or
any file given by path. All are TOML with the settings' names as keys; a mistake is a FormatError with
file:line:column, the line, a caret and did-you-mean.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from engine.core.errors import InputError, UsageError
from engine.core.toml_source import TomlSource, load_toml
from importers.settings import QUALITIES, ImportSettings, declared, did_you_mean

SIDECAR_SUFFIX = ".import"
PROJECT_FILE = "project.toml"
PRESETS_FOLDER = "presets"
#: name -> settings
BUILT_IN: dict[str, dict[str, Any]] = {name: {"quality": name} for name in QUALITIES}


@dataclass(frozen=True, slots=True)
class Resolved:
    """`origins`: setting -> where its value is from (`fox.glb.import:2`, `preset mobile`, `--quality`)."""

    settings: ImportSettings
    origins: dict[str, str]
    preset: str = ""


def sidecar_path(source: Path) -> Path:
    """`fox.glb` -> `fox.glb.import`."""
    return source.with_name(source.name + SIDECAR_SUFFIX)


@dataclass(slots=True)
class SettingsResolver:
    """Settings for many sources: project files and presets are read once. `base`: the settings without any file;
    `preset`, `flags`: what the user said for all of them."""

    base: ImportSettings = field(default_factory=ImportSettings)
    preset: str = ""
    flags: Mapping[str, Any] = field(default_factory=dict)
    _projects: dict[Path, TomlSource | None] = field(default_factory=dict)
    _presets: dict[tuple[str, str], tuple[dict[str, Any], dict[str, str]]] = field(default_factory=dict)

    def resolve(self, source: Path, *, with_sidecar: bool = True) -> Resolved:
        """Raises FormatError (a file with a mistake), UsageError (an unknown preset on the command line)."""
        project = self._project(source.parent)
        sidecar_file = sidecar_path(source)
        sidecar = load_toml(sidecar_file) if with_sidecar and os.path.isfile(sidecar_file) else None  # noqa: PTH113  (a name may be too long)
        values: dict[str, Any] = {}
        origins: dict[str, str] = {}
        wanted = self.preset
        said_by: TomlSource | None = None
        said_at: tuple[str, ...] = ()
        if project is not None:
            table = _table(project, "import")
            _take(project, table, ("import",), values, origins)
            if not wanted and isinstance(table.get("preset"), str):
                wanted, said_by, said_at = table["preset"], project, ("import", "preset")
        if sidecar is not None and not self.preset and isinstance(sidecar.data.get("preset"), str):
            wanted, said_by, said_at = sidecar.data["preset"], sidecar, ("preset",)
        if wanted:
            found, where = self._find_preset(wanted, project, said_by, said_at)
            values |= found
            origins |= where
        if sidecar is not None:
            _take(sidecar, sidecar.data, (), values, origins)
        for name, value in self.flags.items():
            values[name] = value
            origins[name] = declared()[name].flag
        return Resolved(self.base.replace(**values) if values else self.base, origins, wanted)

    def _project(self, folder: Path) -> TomlSource | None:
        """The project.toml of the nearest folder above that has one."""
        if folder in self._projects:
            return self._projects[folder]
        asked, folder = folder, folder.absolute()
        waiting: list[Path] = []
        found: TomlSource | None = None
        for place in (folder, *folder.parents):
            if place in self._projects:
                found = self._projects[place]
                break
            waiting.append(place)
            if (place / PROJECT_FILE).is_file():
                found = load_toml(place / PROJECT_FILE)
                break
        self._projects |= dict.fromkeys([asked, *waiting], found)
        return found

    def _find_preset(
        self, name: str, project: TomlSource | None, said_by: TomlSource | None, said_at: tuple[str, ...]
    ) -> tuple[dict[str, Any], dict[str, str]]:
        """Its values and their origins."""
        key = name, project.file if project is not None else ""
        if key not in self._presets:
            values, origins = self._load_preset(name, project, said_by, said_at)
            self._presets[key] = values, {setting: f"preset {name} ({where})" for setting, where in origins.items()}
        return self._presets[key]

    def _load_preset(
        self, name: str, project: TomlSource | None, said_by: TomlSource | None, said_at: tuple[str, ...]
    ) -> tuple[dict[str, Any], dict[str, str]]:
        values: dict[str, Any] = {}
        origins: dict[str, str] = {}
        tables = _table(project, "presets") if project is not None else {}
        folder = Path(project.file).parent / PRESETS_FOLDER if project is not None else None
        if name in tables:
            assert project is not None
            _take(project, _table(project, "presets", name), ("presets", name), values, origins)
            return values, origins
        file = folder / f"{name}.toml" if folder is not None else None
        if name.endswith(".toml") and said_by is None:
            file = Path(name)
        if file is not None and file.is_file():
            source = load_toml(file)
            _take(source, source.data, (), values, origins, nested=False)
            return values, origins
        if name in BUILT_IN:
            return dict(BUILT_IN[name]), dict.fromkeys(BUILT_IN[name], "built in")
        files = sorted(folder.glob("*.toml")) if folder is not None and folder.is_dir() else []
        known = {**dict.fromkeys(BUILT_IN), **dict.fromkeys(tables), **dict.fromkeys(p.stem for p in files)}
        if said_by is not None:
            raise said_by.error(said_at, f"unknown preset {name!r}", hint=did_you_mean(name, known), value=True)
        raise UsageError(f"unknown preset {name!r}", hint=did_you_mean(name, known))


def resolve(source: Path, base: ImportSettings | None = None) -> Resolved:
    """The settings of one source, as the editor and `lucarna render` use them."""
    return SettingsResolver(base or ImportSettings()).resolve(source)


def read_budgets(start: Path) -> tuple[dict[str, Any], TomlSource | None]:
    """The [budgets] table of the project around `start`, and its file."""
    folder = start if start.is_dir() else start.parent
    project = SettingsResolver()._project(folder)
    return (_table(project, "budgets"), project) if project is not None else ({}, None)


def _table(source: TomlSource, *keys: str) -> dict[str, Any]:
    table: Any = source.data
    for number, key in enumerate(keys, 1):
        table = table.get(key, {})
        if not isinstance(table, dict):
            raise source.error(keys[:number], f"{key!r} must be a table")
    found: dict[str, Any] = table
    return found


def _take(
    source: TomlSource, table: Mapping[str, Any], at: tuple[str, ...], values: dict[str, Any], origins: dict[str, str],
    nested: bool = True,
) -> None:  # fmt: skip
    """Check every key of `table`, which stands at `at` of the file, and add it."""
    known = declared()
    for name, value in table.items():
        place = (*at, name)
        if name == "preset" and at[:1] != ("presets",) and nested:
            if not isinstance(value, str):
                raise source.error(place, "preset must be a text", value=True)
            continue
        if name not in known:
            names = dict.fromkeys([*known, "preset"])
            raise source.error(place, f"unknown setting {name!r}", hint=did_you_mean(name, names))
        try:
            values[name] = known[name].check(value)
        except UsageError as error:
            raise source.error(place, error.message, hint=error.hint, value=True) from None
        where = source.place(place)
        origins[name] = f"{Path(where.file).name}:{where.line}"


def save_sidecar(source: Path, changes: Mapping[str, Any], preset: str | None = None) -> Path:
    """Write what the source wants otherwise into its sidecar; comments and other keys stay. None removes a key.

    What equals the value that the source would have anyway is left out, and a sidecar without a word is removed.
    Raises InputError, FormatError, UsageError, OutputError; the file is then untouched."""
    import tomlkit  # here: only edits need it, and it is slow to import

    from engine.core.atomic import write_text
    from engine.core.toml_source import parse_toml

    known = declared()
    if not source.is_file():
        raise InputError("there is no such file", where=source, hint="a sidecar stands beside its source")
    path = sidecar_path(source)
    document = tomlkit.parse(load_toml(path).text if path.is_file() else "")
    if preset:
        document["preset"] = preset
    elif preset is not None:
        document.pop("preset", None)
    for name in changes:
        if name not in known:
            raise UsageError(f"unknown setting {name!r}", hint=did_you_mean(name, known))
        document.pop(name, None)
    # what it would be without these keys
    plain = SettingsResolver(preset=str(document.get("preset", ""))).resolve(source, with_sidecar=False).settings
    for name, value in changes.items():
        if value is None:
            continue
        checked = known[name].check(value)
        if checked != getattr(plain, name):
            document[name] = list(checked) if isinstance(checked, tuple) else checked
    text = tomlkit.dumps(document)
    values: dict[str, Any] = {}
    parsed = parse_toml(text, str(path))
    _take(parsed, parsed.data, (), values, {})
    if not text.strip():
        path.unlink(missing_ok=True)
    else:
        write_text(path, text)
    return path
