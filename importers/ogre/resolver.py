"""The materials of a mesh: found by name in the scripts around it, inherited, mapped, with their images."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path

from engine.core.errors import InputError
from engine.core.findings import Findings
from importers.gltf.uris import read_regular_file
from importers.model import SourceImage, TextureUse
from importers.ogre.folders import IMAGE_EXTENSIONS, Surroundings
from importers.ogre.inheritance import Library
from importers.ogre.materials import Mapped, default_material, map_material
from importers.ogre.script import Node, Script, parse_script
from importers.settings import ImportSettings

MAX_SCRIPT_BYTES = 16 << 20
#: what Ogre has without any script
_BUILT_IN = {"BaseWhite": False, "BaseWhiteNoLighting": True, "": False}


class Materials:
    """Asks for materials by name give numbers into `mapped`; `images` are those that were found."""

    def __init__(self, around: Surroundings, settings: ImportSettings, findings: Findings) -> None:
        self.mapped: list[Mapped] = []
        self.images: list[SourceImage] = []
        self._around = around
        self._settings = settings
        self._findings = findings
        self._library: Library | None = None
        self._numbers: dict[tuple[str, tuple[tuple[str, str], ...]], int] = {}
        self._image_numbers: dict[Path, int] = {}
        self._scripts: dict[str, Path] = {}
        self._used: dict[Path, None] = {}

    def files(self) -> list[Path]:
        """The scripts and images that were used, sorted."""
        return sorted(self._used)

    def get(self, name: str, aliases: Mapping[str, str]) -> int:
        """The number of the material `name` with a mesh's texture `aliases`. Where it is in no script, a white one
        stands in (a finding says so)."""
        key = name, tuple(sorted(aliases.items()))
        if key not in self._numbers:
            self._numbers[key] = len(self.mapped)
            self.mapped.append(self._make(name, aliases))
        return self._numbers[key]

    def _make(self, name: str, aliases: Mapping[str, str]) -> Mapped:
        library = self._open()
        node = self._find(library, name)
        if node is None:
            return self._stand_in(name)
        problems: list[str] = []
        resolved = library.resolve(node, problems)
        for problem in dict.fromkeys(problems):
            self._findings.warn("ogre.script", f"{Path(node.file).name}:{node.line}: {problem}", f"material {name!r}")
        self._note_files(library, node)
        return map_material(resolved, name, aliases, library, self._image, self._findings)

    # --- scripts ---

    def _open(self) -> Library:
        if self._library is None:
            scripts: list[Script] = []
            for path in self._around.scripts:
                script = self._parse(path)
                if script is not None:
                    scripts.append(script)
            self._library = Library(scripts)
            if not self._around.complete:
                self._findings.warn(
                    "ogre.folders", "there are so many files around the mesh that not all were looked at",
                    hint="give the asset a folder of its own",
                )  # fmt: skip
        return self._library

    def _parse(self, path: Path) -> Script | None:
        try:
            data = read_regular_file(path, MAX_SCRIPT_BYTES)
        except InputError as error:
            self._findings.warn("ogre.script", f"{path.name}: {error.message}", hint=error.hint)
            return None
        script = parse_script(data.decode("utf-8-sig", "replace").replace("\r\n", "\n").replace("\r", "\n"), str(path))
        self._scripts[str(path)] = path
        return script

    def _find(self, library: Library, name: str) -> Node | None:
        found = library.find("material", name)
        if len(found) > 1 and len({node.file for node in found}) > 1:
            files = ", ".join(dict.fromkeys(Path(node.file).name for node in found))
            self._findings.info("ogre.material", f"is in {len(found)} scripts ({files}); the first counts",
                                f"material {name!r}")  # fmt: skip
        if found:
            self._report_problems(library, found[0])
            return found[0]
        similar = [known for known in library.names("material") if known.lower() == name.lower()]
        if similar and name:
            self._findings.warn(
                "ogre.material", f"is written {similar[0]!r} in its script", f"material {name!r}", "spell them alike"
            )
            return library.find("material", similar[0])[0]
        return None

    def _report_problems(self, library: Library, node: Node) -> None:
        for script in library.scripts:
            if script.file == node.file:
                for line, what in script.problems:
                    self._findings.warn("ogre.script", f"{Path(script.file).name}:{line}: {what}")

    def _note_files(self, library: Library, node: Node) -> None:
        """The scripts of the material and of its parents are what it depends on."""
        waiting, seen = [node], set()
        while waiting:
            current = waiting.pop()
            if id(current) in seen:
                continue
            seen.add(id(current))
            if current.file in self._scripts:
                self._used.setdefault(self._scripts[current.file])
            for base in current.bases:
                waiting += library.find(current.kind, base)[:1]
            waiting += current.children
            for prop in current.properties:
                if prop.name == "sampler_ref":
                    waiting += library.find("sampler", " ".join(prop.values))[:1]

    def _stand_in(self, name: str) -> Mapped:
        material = default_material(name or "BaseWhite")
        if name in _BUILT_IN:
            if _BUILT_IN[name]:
                material.asset.features.append("unlit")
            if not name:
                self._findings.info("ogre.material", "a submesh names no material; drawn white")
            return Mapped(material, _BUILT_IN[name])
        where = f"material {name!r}"
        guess = self._guess(name)
        if guess is not None:
            from engine.assets.material import TextureRef

            material.asset.textures["base_color_map"] = TextureRef("")
            material.images["base_color_map"] = TextureUse(self._add_image(guess), "color")
            self._findings.warn(
                "ogre.guess", f"is in no script; {guess.name} is shown, which has its name", where,
                "put its .material script beside the mesh",
            )  # fmt: skip
            return Mapped(material)
        count = len(self._around.scripts)
        near = difflib.get_close_matches(name, self._open().names("material"), 1, 0.7)
        hint = f"did you mean {near[0]!r}?" if near else "put its .material script beside the mesh"
        self._findings.warn("ogre.material", f"is in none of the {count} scripts around; drawn white", where, hint)
        return Mapped(material)

    def _guess(self, name: str) -> Path | None:
        """An image that bears the material's name, with or without extension."""
        last = name.replace("\\", "/").rpartition("/")[2]
        if last.lower().endswith(IMAGE_EXTENSIONS):
            return self._around.find(last)
        return self._around.find_image(last) if last else None

    # --- images ---

    def _image(self, texture: str, where: str) -> int | None:
        """The number of the image called `texture`; None (with a finding) where it is not there."""
        path = self._around.find(texture)
        if path is not None and not path.name.lower().endswith(IMAGE_EXTENSIONS):
            path = None
        if path is None:
            last = texture.replace("\\", "/").rpartition("/")[2]
            path = self._around.find_image(last.rpartition(".")[0] or last)
            if path is None:
                near = difflib.get_close_matches(last.lower(), self._around.images(), 1, 0.75)
                self._findings.error(
                    "ogre.image", f"the texture {texture[:120]!r} is not there; it draws as magenta", where,
                    f"did you mean {near[0]!r}?" if near else "put it beside the mesh or into ../materials/textures",
                )  # fmt: skip
                return None
            self._findings.warn(
                "ogre.guess", f"the texture {texture[:120]!r} is not there; {path.name} is shown", where
            )
        return self._add_image(path)

    def _add_image(self, path: Path) -> int:
        if path not in self._image_numbers:
            self._image_numbers[path] = len(self.images)
            self._used.setdefault(path)
            self.images.append(SourceImage(path.stem, lambda: self._read(path), path.name, str(path)))
        return self._image_numbers[path]

    def _read(self, path: Path) -> bytes | None:
        try:
            return read_regular_file(path, self._settings.max_file_bytes)
        except InputError as error:
            self._findings.error("ogre.image", f"{error.message}; it draws as magenta", path.name, error.hint)
            return None
