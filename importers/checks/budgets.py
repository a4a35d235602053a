"""Budgets: how much of what a file may have. From `check --budget triangles=50000,bones=64` and project.toml:

    [budgets]
    triangles = 50_000
    texture-bytes = 16_000_000

A file over budget is an error of code `budget.NAME`. What is counted is what a scene draws and a graphics card holds:
triangles of a mesh count once for each node that shows it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from engine.core.errors import UsageError
from engine.core.findings import Findings
from importers.settings import ImportSettings, did_you_mean

if TYPE_CHECKING:
    from engine.core.toml_source import TomlSource
    from importers.contents import Contents


@dataclass(frozen=True, slots=True)
class Budget:
    """`measure` gives the amount and where the most of it is."""

    name: str
    what: str
    remedy: str
    measure: Callable[[Contents, Path, ImportSettings], tuple[float, str]]


def check_budgets(
    contents: Contents, path: Path, budgets: Mapping[str, float], settings: ImportSettings, findings: Findings
) -> None:
    """Add an error for each of `budgets` that `contents` exceeds."""
    for name, limit in budgets.items():
        budget = BUDGETS[name]
        amount, where = budget.measure(contents, path, settings)
        if amount > limit:
            findings.error(
                f"budget.{name}", f"{amount:,.0f} {budget.what}, the budget is {limit:,.0f}", where, budget.remedy
            )


def parse_budgets(text: str) -> dict[str, float]:
    """`triangles=50000,bones=64` -> limits by name. Raises UsageError."""
    found: dict[str, float] = {}
    for part in filter(None, (piece.strip() for piece in text.split(","))):
        name, given, value = part.partition("=")
        name = name.strip()
        if name not in BUDGETS:
            raise UsageError(f"--budget: unknown budget {name!r}", hint=did_you_mean(name, BUDGETS))
        try:
            found[name] = _limit(float(value.replace("_", "")))
        except ValueError:
            hint = f"write {name}=NUMBER" if not given else "give a number that is not negative"
            raise UsageError(f"--budget: {part!r} has no limit", hint=hint) from None
    return found


def budgets_of(table: Mapping[str, Any], source: TomlSource) -> dict[str, float]:
    """The limits of a [budgets] table. Raises FormatError with file:line:column."""
    found = {}
    for name, value in table.items():
        if name not in BUDGETS:
            raise source.error(("budgets", name), f"unknown budget {name!r}", hint=did_you_mean(name, BUDGETS))
        try:
            found[name] = _limit(value)
        except ValueError:
            raise source.error(("budgets", name), f"{name} is {value!r}", hint="give a number that is not negative",
                               value=True) from None  # fmt: skip
    return found


def _limit(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value >= 0:
        raise ValueError
    return float(value)


def _shown(contents: Contents, per_mesh: Callable[[Any], int]) -> tuple[float, str]:
    """The sum over all that nodes show (over the meshes, where there are no nodes), and the mesh that has most."""
    each = [per_mesh(mesh) for mesh in contents.meshes]
    times = [0] * len(each)
    for node in contents.nodes:
        if node.mesh is not None and 0 <= node.mesh.index < len(each):
            times[node.mesh.index] += 1
    if not contents.nodes:
        times = [1] * len(each)
    total = sum(count * amount for count, amount in zip(times, each, strict=True))
    most = max(range(len(each)), key=lambda i: times[i] * each[i], default=-1)
    return total, f"meshes[{most}]" if most >= 0 else ""


def _bones(contents: Contents, path: Path, settings: ImportSettings) -> tuple[float, str]:
    counts = [len(mesh.skeleton.names) if mesh.skeleton is not None else 0 for mesh in contents.meshes]
    most = max(range(len(counts)), key=counts.__getitem__, default=-1)
    return (counts[most], f"meshes[{most}].skeleton") if most >= 0 else (0, "")


def _triangles(contents: Contents, path: Path, settings: ImportSettings) -> tuple[float, str]:
    return _shown(contents, lambda mesh: sum(s.index_count // 3 for s in mesh.submeshes if s.topology == "triangles"))


def _texture_bytes(contents: Contents, path: Path, settings: ImportSettings) -> tuple[float, str]:
    """Of converted textures as they are; of a source's images, what conversion will make of them at one byte a texel
    (BC7, BC5), or four, with a third for the mips."""
    sizes = []
    for texture in contents.textures:
        if texture.mips:
            sizes.append(float(texture.bytes))
            continue
        width, height = texture.width, texture.height
        while settings.max_texture_size and max(width, height) > settings.max_texture_size:
            width, height = max(1, width // 2), max(1, height // 2)
        sizes.append(width * height * (1.0 if settings.compress else 4.0) * 4.0 / 3.0)
    most = max(range(len(sizes)), key=sizes.__getitem__, default=-1)
    return sum(sizes), f"textures[{most}]" if most >= 0 else ""


def _texture_size(contents: Contents, path: Path, settings: ImportSettings) -> tuple[float, str]:
    sizes = [max(texture.width, texture.height) for texture in contents.textures]
    most = max(range(len(sizes)), key=sizes.__getitem__, default=-1)
    return (sizes[most], f"textures[{most}]") if most >= 0 else (0, "")


def _counted(field: str) -> Callable[[Contents, Path, ImportSettings], tuple[float, str]]:
    return lambda contents, path, settings: (len(getattr(contents, field)), field)


BUDGETS: dict[str, Budget] = {
    budget.name: budget
    for budget in (
        Budget("triangles", "triangles are drawn", "simplify, or show fewer instances", _triangles),
        Budget("vertices", "vertices are drawn", "merge seams, simplify",
               lambda contents, path, settings: _shown(contents, lambda mesh: mesh.vertex_count)),
        Budget("draws", "parts are drawn", "merge materials and meshes",
               lambda contents, path, settings: _shown(contents, lambda mesh: len(mesh.submeshes))),
        Budget("bones", "bones in one mesh", "remove joints that move nothing of their own", _bones),
        Budget("texture-bytes", "bytes of textures", "use --max-texture-size, or share textures", _texture_bytes),
        Budget("texture-size", "texels along the largest texture's longer side", "use --max-texture-size",
               _texture_size),
        Budget("meshes", "meshes", "merge meshes", _counted("meshes")),
        Budget("materials", "materials", "merge materials that look alike", _counted("materials")),
        Budget("textures", "textures", "pack or share textures", _counted("textures")),
        Budget("nodes", "nodes", "remove empty nodes", _counted("nodes")),
        Budget("clips", "clips", "split the file, or remove takes", _counted("clips")),
        Budget("file-bytes", "bytes of the file", "split the file, or reduce what is in it",
               lambda contents, path, settings: (path.stat().st_size, "")),
    )
}  # fmt: skip
