"""ImportedModel: what every importer yields, in memory and without a trace of the source's format."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from engine.assets.clip import ClipAsset
from engine.assets.material import MaterialAsset
from engine.assets.mesh import MeshAsset
from engine.assets.scene import EnvironmentAsset, LookAsset, NodeAsset
from engine.assets.texture import TextureAsset
from engine.core.findings import Findings


@dataclass(slots=True)
class SourceImage:
    """An image of the source, still encoded. `data` gives None where it is not to be had (a finding says why).

    `name` may be empty: then the first slot that shows it names its file. `path`: where it is in the
    source (`images[2]`), for findings. `file`: its file, where it has one of its own. `flip_green`: a normal map with
    +Y down, as its name says.
    """

    name: str
    data: Callable[[], bytes | None]
    path: str
    file: str = ""
    flip_green: bool = False


@dataclass(frozen=True, slots=True)
class TextureUse:
    """Which image a slot shows, and as what: the role (color, normal, metal_rough, occlusion) picks the encoding.

    `alpha_cutoff`: the alpha test's threshold on the image's own alpha; its mips then keep what passes."""

    image: int
    role: str
    alpha_cutoff: float | None = None


@dataclass(slots=True)
class ImportedMaterial:
    """A material whose TextureRefs have no path yet; `images` maps each of its slots to an image and a role.

    A slot without an entry in `images` stays without a path: wanted but missing."""

    asset: MaterialAsset
    images: dict[str, TextureUse] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class LoneTexture:
    """The texture of a source that is an image itself; its file is named as the source.

    `build` makes it, and raises InputError. The base colour of the only material shows it, where there is one; with
    `environment` it is the scene's light."""

    build: Callable[[], TextureAsset]
    environment: bool = False


@dataclass(slots=True)
class ImportedModel:
    """A whole source. `slots[m][s]` is the material index of slot s of mesh m, -1 for the default material.

    Nodes name meshes by MeshRef.index into `meshes`; MeshRef.file and .materials are filled in by `convert`.
    Nodes stand with parents before children. `summary` holds counts of the source for `lucarna inspect`.
    """

    name: str
    findings: Findings
    meshes: list[MeshAsset] = field(default_factory=list)
    slots: list[list[int]] = field(default_factory=list)
    materials: list[ImportedMaterial] = field(default_factory=list)
    images: list[SourceImage] = field(default_factory=list)
    lone: LoneTexture | None = None
    nodes: list[NodeAsset] = field(default_factory=list)
    clips: list[ClipAsset] = field(default_factory=list)
    active_camera: int = -1
    environment: EnvironmentAsset = field(default_factory=EnvironmentAsset)
    look: LookAsset = field(default_factory=LookAsset)
    #: IES files by the name that LightAsset.profile has; `convert` writes them beside the scene
    profiles: dict[str, bytes] = field(default_factory=dict)
    dependencies: list[Path] = field(default_factory=list)
    summary: dict[str, object] = field(default_factory=dict)
