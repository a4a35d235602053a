"""Textures that lie beside a model without being named in it, found by their names; and materials as settings want.

    materials without any texture <- files in the model's folder (and textures/, maps/ … in it) whose name is the
    material's, the model's, or that of the only set there, with a suffix for what it holds (texture_names.py)

Every guess is a finding with its reason. `[materials.NAME]` of a sidecar or project has the last word:
`normal_map = "other.png"`, `normal_map = false`, or a number for a parameter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engine.assets.material import MaterialAsset, TextureRef
from importers.geometry.added_tangents import add_tangents
from importers.model import ImportedMaterial, ImportedModel, SourceImage, TextureUse
from importers.settings import ImportSettings
from importers.texture_names import TextureName, plain, read_name
from importers.texture_settings import unmatched

IMAGE_EXTENSIONS = (
    ".png", ".jpg", ".jpeg", ".tga", ".bmp", ".tif", ".tiff", ".webp", ".psd", ".dds", ".ktx2", ".exr", ".hdr", ".avif",
)  # fmt: skip
#: folders in the model's own that are searched as well
FOLDERS = ("textures", "texture", "tex", "maps", "materials", "images")
MAX_FILES = 2000
#: slot -> role of its image
SLOTS = {
    "base_color_map": "color", "metal_rough_map": "metal_rough", "normal_map": "normal", "occlusion_map": "occlusion",
    "emissive_map": "color",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Found:
    """A file beside the model and what its name says."""

    path: Path
    name: TextureName


def complete(model: ImportedModel, source: Path, settings: ImportSettings) -> None:
    """Give materials without textures those that lie beside `source`, and all of them what the settings say."""
    if settings.loose_textures and any(_bare(m) for m in model.materials):
        _guess(model, source, settings)
    if settings.materials:
        for material in model.materials:
            _override(model, material, source, settings)
    if settings.materials or settings.textures:
        unmatched(model, settings)


def _bare(material: ImportedMaterial) -> bool:
    return not material.asset.textures and material.asset.effect == "surface"


def files_beside(source: Path) -> list[Found]:
    """Image files in the source's folder and in the usual ones below it, sorted by path."""
    folders = [source.parent]
    try:
        wanted = {*FOLDERS, f"{source.stem.lower()}.fbm", f"{source.stem.lower()}_textures"}
        folders += sorted(p for p in source.parent.iterdir() if p.name.lower() in wanted and p.is_dir())
        files = sorted(
            p for folder in folders for p in folder.iterdir() if p.suffix.lower() in IMAGE_EXTENSIONS and p.is_file()
        )
    except OSError:
        return []
    return [Found(p, read_name(p.stem)) for p in files[:MAX_FILES]]


def _guess(model: ImportedModel, source: Path, settings: ImportSettings) -> None:
    found = [f for f in files_beside(source) if f.name.role]
    if not found:
        return
    sets: dict[str, list[Found]] = {}
    for file in found:
        sets.setdefault(plain(file.name.base), []).append(file)
    bare = [m for m in model.materials if _bare(m)]
    for material in bare:
        key, reason = plain(material.asset.name), "named as the material"
        if key not in sets and len(bare) == 1:
            key, reason = plain(source.stem), "named as the file, which has one material without textures"
            if key not in sets and len(sets) == 1 and len(model.materials) == 1:
                key, reason = next(iter(sets)), "the only set of textures beside a file with one material"
        if key in sets:
            _apply(model, material, sets[key], reason, settings)


def _apply(
    model: ImportedModel, material: ImportedMaterial, files: list[Found], reason: str, settings: ImportSettings
) -> None:
    by_role: dict[str, Path] = {}
    for file in files:
        if file.name.role in by_role:
            model.findings.info(
                "materials.guess", f"{file.path.name} is left out: {by_role[file.name.role].name} is of its kind, too",
                f"materials[{material.asset.name}]",
            )  # fmt: skip
        by_role.setdefault(file.name.role, file.path)
    asset, where = material.asset, f"materials[{material.asset.name}]"
    said = settings.table("materials", asset.name)

    def put(slot: str, image: int, what: str) -> None:
        asset.textures[slot] = TextureRef("")
        material.images[slot] = TextureUse(image, SLOTS[slot])
        if slot in said:  # which has the last word: no guess stays
            return
        model.findings.info(
            "materials.guess", f"{slot} = {what}: {reason}", where,
            f"override it in the sidecar: [materials.{asset.name!r}] {slot} = false, or another file",
        )  # fmt: skip

    if "color" in by_role:
        put("base_color_map", _image(model, by_role["color"], settings), by_role["color"].name)
        base = asset.params.get("base_color", (1.0, 1.0, 1.0, 1.0))
        asset.params["base_color"] = (1.0, 1.0, 1.0, base[3])
    for role in ("normal", "normal_dx"):
        if role in by_role and "normal_map" not in asset.textures and _with_tangents(model, material, where):
            put("normal_map", _image(model, by_role[role], settings, flip=role == "normal_dx"), by_role[role].name)
    packed = by_role.get("orm") or by_role.get("metal_rough")
    if packed is not None:
        image = _image(model, packed, settings)
        put("metal_rough_map", image, packed.name)
        asset.params |= {"metallic": 1.0, "roughness": 1.0}
        if "orm" in by_role and "occlusion" not in by_role:
            put("occlusion_map", image, packed.name)
    elif {"rough", "gloss", "metal"} & by_role.keys():
        rough = by_role.get("rough") or by_role.get("gloss")
        metal = by_role.get("metal")
        image = _packed(model, rough, metal, gloss="rough" not in by_role, settings=settings)
        put("metal_rough_map", image, " + ".join(p.name for p in (rough, metal) if p is not None))
        if rough is not None:
            asset.params["roughness"] = 1.0
        if metal is not None:
            asset.params["metallic"] = 1.0
    if "occlusion" in by_role:
        put("occlusion_map", _image(model, by_role["occlusion"], settings), by_role["occlusion"].name)
    if "emissive" in by_role:
        put("emissive_map", _image(model, by_role["emissive"], settings), by_role["emissive"].name)
        asset.params["emissive"] = (1.0, 1.0, 1.0)
    for role in ("height", "opacity"):
        if role in by_role:
            model.findings.info(
                "materials.guess", f"{by_role[role].name} holds {role}, which has no slot; left out", where
            )


def _image(model: ImportedModel, path: Path, settings: ImportSettings, flip: bool = False) -> int:
    """The number of the image file in the model."""
    for k, known in enumerate(model.images):
        if known.file == str(path) and known.flip_green == flip:
            return k
    model.images.append(SourceImage(path.stem, _reader(model, path, settings), path.name, str(path), flip))
    if path not in model.dependencies:
        model.dependencies.append(path)
    return len(model.images) - 1


def _reader(model: ImportedModel, path: Path, settings: ImportSettings) -> Callable[[], bytes | None]:
    def read() -> bytes | None:
        from engine.core.errors import InputError
        from importers.gltf.uris import read_regular_file

        try:
            return read_regular_file(path, settings.max_file_bytes)
        except InputError as error:
            model.findings.error("materials.image", error.message, path.name, error.hint)
            return None

    return read


def _packed(
    model: ImportedModel, rough: Path | None, metal: Path | None, *, gloss: bool, settings: ImportSettings
) -> int:
    """One image of both, as the slot wants it: G roughness, B metallic."""
    readers = [None if p is None else _reader(model, p, settings) for p in (rough, metal)]

    def read() -> bytes | None:
        from importers.textures.packing import pack_metal_rough

        parts = [None if reader is None else reader() for reader in readers]
        return pack_metal_rough(parts[0], parts[1], gloss, settings)

    first = rough or metal
    assert first is not None
    base = read_name(first.stem).base.replace(" ", "_")
    model.images.append(SourceImage(f"{base}_metal_rough", read, first.name, str(first)))
    model.dependencies += [p for p in (rough, metal) if p is not None and p not in model.dependencies]
    return len(model.images) - 1


def _with_tangents(model: ImportedModel, material: ImportedMaterial, where: str) -> bool:
    """Give the meshes that show the material tangents; False (with a finding) where some cannot have them."""
    number = next(k for k, m in enumerate(model.materials) if m is material)
    meshes = [mesh for mesh, slots in zip(model.meshes, model.slots, strict=True) if number in slots]
    if not all(add_tangents(mesh) for mesh in meshes):
        model.findings.warn(
            "materials.guess", "a normal map lies beside the file, but a mesh lacks texture coordinates", where,
            "unwrap the mesh",
        )  # fmt: skip
        return False
    return True


def _override(model: ImportedModel, material: ImportedMaterial, source: Path, settings: ImportSettings) -> None:
    """What `[materials.NAME]` says: a slot's file, false for none, or a parameter's value."""
    asset, where = material.asset, f"materials[{material.asset.name}]"
    table = settings.table("materials", asset.name)
    for key, value in table.items():
        if key in SLOTS and value is False:
            asset.textures.pop(key, None)
            material.images.pop(key, None)
        elif key in SLOTS and isinstance(value, str):
            path = source.parent / value
            inside = path.resolve().is_relative_to(source.parent.resolve())
            if not path.is_file() or not (inside or settings.allow_outside):
                model.findings.error(
                    "materials.image", f"{key} = {value!r}: {'no such file' if inside else 'leads out of the folder'}",
                    where,
                    "give a path from the source's folder",
                )  # fmt: skip
                continue
            if key == "normal_map" and not _with_tangents(model, material, where):
                continue
            asset.textures.setdefault(key, TextureRef(""))
            material.images[key] = TextureUse(_image(model, path, settings), SLOTS[key])
        elif key not in SLOTS and _is_value(value):
            mistake = _mistake(asset, key, value)
            if mistake:
                model.findings.warn("materials.setting", f"{key} = {value!r} is left out: {mistake}", where)
            else:
                asset.params[key] = tuple(value) if isinstance(value, list) else value
        else:
            model.findings.warn(
                "materials.setting", f"{key} = {value!r} is not understood", where,
                f"slots ({', '.join(SLOTS)}) take a file or false, parameters a number or a list of numbers",
            )  # fmt: skip


def _mistake(asset: MaterialAsset, name: str, value: Any) -> str:
    """What is wrong with a parameter's value, or its name: a material that holds such could not be drawn."""
    from engine.core.errors import UsageError
    from engine.core.paths import shaders_dir
    from engine.materials.library import EffectLibrary

    library = EffectLibrary([shaders_dir()])
    if asset.effect not in library.names():
        return ""
    try:
        library.get(asset.effect).param(name).check(value)
    except UsageError as error:
        return str(error)
    return ""


def _is_value(value: Any) -> bool:
    numbers = value if isinstance(value, (list, tuple)) and value else [value]
    return all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in numbers)
