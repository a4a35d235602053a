"""`mv`: give a file or folder of a project another name or place, and let every reference to it follow.

All or nothing: what is to be rewritten is worked out first and checked; a failure on the way puts everything back, and
so does the next one to open or move something there when the process was killed (move_log.py).
The sidecar of a source goes with it. Sources (glTF, OBJ) are never rewritten: where one would lose a file that it
names, the move is refused.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from engine.core.atomic import write_bytes
from engine.core.errors import InputError, OutputError, UsageError
from importers.project import move_log
from importers.project.references import Reference, all_references, files_of, project_root

#: names that Windows keeps for devices
RESERVED = {"con", "prn", "aux", "nul", *(f"{n}{i}" for n in ("com", "lpt") for i in range(1, 10))}
#: endings that say what a file is, though they have two dots
KINDS = (".material.toml", ".effect.toml", ".scene.json", ".animation.toml", ".mask.toml", ".mesh.xml", ".env.dds")


@dataclass(slots=True)
class Move:
    """What a move does. `files`: old place -> new one, of every file; `rewritten`: file, where it lies afterwards ->
    (bytes before, bytes after); `references`: those that follow."""

    old: Path
    new: Path
    root: Path
    files: dict[Path, Path]
    references: list[Reference] = field(default_factory=list)
    rewritten: dict[Path, tuple[bytes, bytes]] = field(default_factory=dict)
    made: list[Path] = field(default_factory=list)

    def to_json(self) -> dict[str, Any]:
        def short(path: Path) -> str:
            return path.relative_to(self.root).as_posix()

        return {
            "from": short(self.old), "to": short(self.new),
            "files": {short(a): short(b) for a, b in self.files.items()},
            "rewritten": [short(p) for p in self.rewritten],
        }  # fmt: skip

    def apply(self) -> None:
        """Do it. Raises OutputError; then everything is as it was."""
        files, contents = self.files, {p: after for p, (_before, after) in self.rewritten.items()}
        done: list[tuple[Path, Path]] = []
        written: list[tuple[Path, bytes]] = []
        made: list[Path] = []
        try:
            move_log.begin(self.root, files, contents, _missing_folders(new.parent for new in files.values()))
            for old, new in files.items():
                if new.exists() and not _same_file(old, new):
                    raise OutputError("there is a file of this name already", where=new, hint="choose another name")
                made += _make_folders(new.parent)
                old.rename(new)
                done.append((old, new))
            for path, data in contents.items():
                before = path.read_bytes()
                write_bytes(path, data)
                written.append((path, before))
        except (OSError, OutputError) as error:
            for path, before in reversed(written):
                write_bytes(path, before)
            for old, new in reversed(done):
                new.rename(old)
            for folder in reversed(made):
                folder.rmdir()
            move_log.end(self.root)
            if isinstance(error, OutputError):
                raise
            raise OutputError(
                f"cannot move: {error.strerror or error}", where=error.filename or self.new,
                hint="nothing was changed",
            ) from error  # fmt: skip
        move_log.end(self.root)
        _remove_empty(self.old)

    def undo(self) -> None:
        """`reverse`, done."""
        self.reverse().apply()

    def reverse(self) -> Move:
        """What puts everything back, to the byte; a file that was changed since keeps that and only its references
        follow. Raises InputError where something is not where it was moved to, or its old place is taken."""
        gone = [new for new in self.files.values() if not new.exists()]
        taken = [old for old, new in self.files.items() if old.exists() and not _same_file(old, new)]
        if gone or taken:
            what = f"{gone[0].name} is gone" if gone else f"its old place {taken[0].name} is taken"
            raise InputError(
                f"the move of {self.old.name} cannot be undone: {what}", where=(gone or taken)[0],
                hint="put it back there, then undo again" if gone else "move what is there away, then undo again",
            )  # fmt: skip
        back = plan(self.new, self.old, root=self.root)
        for path, (before, after) in self.rewritten.items():
            if path.is_file() and path.read_bytes() == after:
                back.rewritten[back.files.get(path, path)] = after, before
        return back

    def again(self) -> Move:
        """The same move as it is now, after it was undone. Raises as `plan`, and where its new place is taken."""
        if self.new.exists() and not _same_file(self.old, self.new):
            raise InputError(
                f"the move of {self.old.name} cannot be done again: its place is taken", where=self.new,
                hint="move what is there away, then redo",
            )  # fmt: skip
        return plan(self.old, self.new, root=self.root)


def used_by(path: Path, found: Sequence[Reference]) -> list[Reference]:
    """Who names `path`, or something in it where it is a folder."""
    return [r for r in found if r.target == path or path in r.target.parents]


def uses(path: Path, found: Sequence[Reference]) -> list[Reference]:
    """What `path` names."""
    return [r for r in found if r.file == path]


def plan(old: Path, new: Path, *, root: Path | None = None) -> Move:
    """What moving `old` to `new` (a new name, or a folder that is there) would do; nothing is written.

    Raises UsageError for bad names and clashes, InputError where a source would lose what it names."""
    old = Path(os.path.normpath(old.absolute()))
    new = Path(os.path.normpath(new.absolute()))
    root = Path(os.path.normpath((root or project_root(old)).absolute()))
    move_log.recover(root)
    if not old.exists():
        raise InputError("there is no such file or folder", where=old)
    if new.is_dir() and not _same_file(old, new):
        new = new / old.name
    _check(old, new, root)
    files = files_of(root)
    moved = _moved(old, new, files)
    found = all_references(root, files)
    move = Move(old, new, root, moved)
    edits: dict[Path, list[tuple[Reference, str]]] = {}
    broken = []
    for ref in found:
        text = _new_text(ref, moved)
        if text == ref.text:
            continue
        if ref.fixed:
            broken.append(ref)
            continue
        edits.setdefault(ref.file, []).append((ref, text))
        move.references.append(ref)
    if broken:
        lost = ", ".join(f"{r.file.name} names {r.text}" for r in broken[:4])
        more = f" and {len(broken) - 4} more" if len(broken) > 4 else ""
        raise InputError(
            f"a source would lose what it names: {lost}{more}", where=old,
            hint="sources are never rewritten: move them together, as the folder that holds them all",
        )  # fmt: skip
    if old.name.endswith(".effect.toml") and old.name != new.name:
        _rename_effect(move, edits)
    for file, changes in edits.items():
        before = file.read_bytes()
        move.rewritten[moved.get(file, file)] = (before, _rewrite(file, before, changes))
    return move


def _rename_effect(move: Move, edits: dict[Path, list[tuple[Reference, str]]]) -> None:
    """An effect's file is found by its name, so the name that it gives itself follows, too."""
    import tomllib

    try:
        name = tomllib.loads(move.old.read_text("utf-8")).get("name")
    except (OSError, ValueError):
        return
    if name == _stem(move.old):
        ref = Reference(move.old, ("name",), name, move.old, move.old.parent)
        edits.setdefault(move.old, []).append((ref, _stem(move.new)))


def _stem(path: Path) -> str:
    return path.name.removesuffix(".effect.toml")


def _moved(old: Path, new: Path, files: Sequence[Path]) -> dict[Path, Path]:
    if old.is_dir():
        inside = {f: new / f.relative_to(old) for f in files if old in f.parents}
        hidden = [Path(b) / n for b, _d, names in os.walk(old) for n in names if Path(b) / n not in inside]
        return inside | {f: new / f.relative_to(old) for f in hidden}
    moved = {old: new}
    sidecar = old.with_name(f"{old.name}.import")
    if sidecar.is_file():
        moved[sidecar] = new.with_name(f"{new.name}.import")
        if moved[sidecar].exists():
            raise UsageError("there is a sidecar of this name already", where=moved[sidecar])
    return moved


def _new_text(ref: Reference, moved: Mapping[Path, Path]) -> str:
    """What `ref` has to say after the move, in the form it has now."""
    target, file = moved.get(ref.target, ref.target), moved.get(ref.file, ref.file)
    if ref.by_name:
        return _stem(target) if target != ref.target else ref.text
    if target == ref.target and file == ref.file:
        return ref.text
    base = file.parent if ref.base == ref.file.parent else ref.base
    if Path(os.path.normpath(base / ref.text)) == target:
        return ref.text
    if Path(ref.text).is_absolute():
        return str(target)
    return Path(os.path.relpath(target, base)).as_posix()


def _rewrite(file: Path, before: bytes, changes: Sequence[tuple[Reference, str]]) -> bytes:
    """The content of `file` with other references; comments and order stay."""
    text = before.decode("utf-8")
    if file.name.endswith(".scene.json"):
        data = json.loads(text)
        for ref, new in changes:
            _put(data, ref.keys, new)
        from engine.assets.scene_json import format_scene, parse_scene

        return format_scene(parse_scene(json.dumps(data), str(file))).encode("utf-8")
    if file.name.endswith((".toml", ".import")):
        import tomlkit

        document = tomlkit.parse(text)
        for ref, new in changes:
            if ref.is_key:
                table: Any = document[str(ref.keys[0])]
                table[new] = table.pop(ref.keys[1])
            else:
                _put(document, ref.keys, new)
        return tomlkit.dumps(document).encode("utf-8")
    for ref, new in changes:
        pattern = rf'(^\s*#\s*include\s*"){re.escape(ref.text)}(")'
        text = re.sub(pattern, lambda m, new=new: f"{m[1]}{new}{m[2]}", text, flags=re.M)  # type: ignore[misc]  # a default argument binds it
    return text.encode("utf-8")


def _put(data: Any, keys: Sequence[str | int], value: str) -> None:
    for key in keys[:-1]:
        data = data[key]
    data[keys[-1]] = value


def _check(old: Path, new: Path, root: Path) -> None:
    """Raise UsageError where the move cannot be meant."""
    if old == root or old.name == "project.toml":
        raise UsageError("the project itself cannot be moved from inside", where=old, hint="rename its folder")
    for path, what in ((old, "it"), (new, "the new place")):
        if root not in path.parents:
            raise UsageError(f"{what} lies outside the project", where=path, hint=f"the project is {root}")
    if new == old:
        raise UsageError("the new name is the old one", where=old)
    if old in new.parents:
        raise UsageError("a folder cannot be moved into itself", where=new)
    for part in new.relative_to(root).parts:
        problem = bad_name(part)
        if problem:
            raise UsageError(f"{part!r} is no good name: {problem}", where=new)
    if new.exists() and not _same_file(old, new):
        raise UsageError("there is a file or folder of this name already", where=new, hint="choose another name")
    if new.parent.exists() and not new.parent.is_dir():
        raise UsageError("the new place is a file, not a folder", where=new.parent)
    if old.is_file() and kind_ending(old) != kind_ending(new):
        raise UsageError(
            f"the ending says what a file is: {kind_ending(old) or 'none'} cannot become {kind_ending(new) or 'none'}",
            where=new, hint=f"call it {new.name.split('.')[0]}{kind_ending(old)}",
        )  # fmt: skip


def kind_ending(path: Path) -> str:
    """`.material.toml`, `.glb`: what a rename must keep."""
    lowered = path.name.lower()
    return next((kind for kind in KINDS if lowered.endswith(kind)), path.suffix.lower())


def bad_name(name: str) -> str:
    """Why a file cannot be called so on every system, or ''."""
    if not name or name.startswith("."):
        return "it is empty or hidden"
    if re.search(r'[<>:"|?*\\\x00-\x1f]', name):
        return 'it has one of < > : " | ? * \\ or a control character'
    if name[-1] in ". " or name[0] == " ":
        return "it begins or ends with a blank, or ends with a dot"
    if name.split(".")[0].lower() in RESERVED:
        return "Windows keeps it for a device"
    return "it is too long" if len(name.encode("utf-8")) > 255 else ""


def _same_file(one: Path, other: Path) -> bool:
    """Whether both names are of one file, as on a disk that does not tell letter case apart."""
    try:
        return one.samefile(other)
    except OSError:
        return False


def _missing_folders(folders: Iterable[Path]) -> list[Path]:
    """Those that are not there, with what they lie in, outer ones first."""
    missing = {place for folder in folders for place in (folder, *folder.parents) if not place.exists()}
    return sorted(missing, key=lambda place: len(place.parts))


def _make_folders(folder: Path) -> list[Path]:
    missing = []
    while not folder.exists():
        missing.append(folder)
        folder = folder.parent
    for path in reversed(missing):
        path.mkdir()
    return missing[::-1]


def _remove_empty(folder: Path) -> None:
    """Remove the folders that a moved one has left; none where `folder` was a file."""
    for base, _folders, _names in os.walk(folder, topdown=False):
        try:
            Path(base).rmdir()
        except OSError:
            return
