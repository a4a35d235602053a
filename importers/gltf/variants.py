"""KHR_materials_variants: which material a primitive shows in which variant; one of them can be chosen for import.

Source: KHR_materials_variants (Khronos, 2020). All of it is kept in MeshAsset.extras[EXTRAS]:
{"names": [variant, …], "slots": [[material index or -1 a variant], …]}, one entry a material slot; in our files also
"files" (see name_variants).
"""

from __future__ import annotations

from engine.assets.mesh import MeshAsset
from importers.gltf.document import Document, JsonObject

NAME = "KHR_materials_variants"
EXTRAS = "material_variants"


def name_variants(mesh: MeshAsset, files: list[str]) -> None:
    """Add `files` to what the mesh keeps: as `slots`, by material file (relative to the scene; '' for none)."""
    kept = mesh.extras.get(EXTRAS)
    if isinstance(kept, dict):
        kept["files"] = [[files[i] if 0 <= i < len(files) else "" for i in slot] for slot in kept["slots"]]


#: (variant, material) pairs, sorted
Mapping = tuple[tuple[int, int], ...]


class Variants:
    """The file's variants and the one to show (`wanted`: its name, '' for the plain materials)."""

    def __init__(self, doc: Document, wanted: str) -> None:
        self._doc = doc
        holder = doc.extension(doc.root, NAME, "") or {}
        where = f"extensions.{NAME}.variants"
        entries = doc.child_objects(holder, "variants", f"extensions.{NAME}")
        self.names = [doc.name(entry, f"{where}[{k}]", f"variant_{k}") for k, entry in enumerate(entries)]
        self._shown = -1
        if not self.names:
            return
        listed = ", ".join(map(repr, self.names[:20]))
        matches = [k for k, name in enumerate(self.names) if name.lower() == wanted.lower()]
        if wanted and matches:
            self._shown = matches[0]
            doc.findings.info("gltf.variants", f"the variant {self.names[matches[0]]!r} is shown, of {listed}", where)
        elif wanted:
            doc.findings.warn("gltf.variants", f"there is no variant {wanted!r}; the plain materials are shown", where,
                              f"variants: {listed}")  # fmt: skip
        else:
            doc.findings.info("gltf.variants", f"the file has the variants {listed}; all are kept", where,
                              "choose one with --variant NAME")  # fmt: skip

    def read(self, primitive: JsonObject, material: int, where: str) -> tuple[int, Mapping]:
        """The material to show, and the primitive's mapping."""
        extension = self._doc.extension(primitive, NAME, where) if self.names else None
        if extension is None:
            return material, ()
        place = f"{where}.extensions.{NAME}"
        pairs: dict[int, int] = {}
        for k, entry in enumerate(self._doc.child_objects(extension, "mappings", place)):
            at = f"{place}.mappings[{k}]"
            number = self._doc.index(entry, "material", at, "materials")
            for variant in self._doc.array(entry, "variants", at):
                if not isinstance(variant, int) or not 0 <= variant < len(self.names):
                    self._doc.findings.error("gltf.index", f"variant {variant!r} does not exist", f"{at}.variants")
                elif number is not None:
                    pairs[variant] = number
        return pairs.get(self._shown, material), tuple(sorted(pairs.items()))

    def extras(self, mappings: list[Mapping]) -> dict[str, object] | None:
        """What the mesh keeps, from its slots' mappings; None where there is none."""
        if not any(mappings):
            return None
        return {
            "names": self.names,
            "slots": [[dict(mapping).get(k, -1) for k in range(len(self.names))] for mapping in mappings],
        }
