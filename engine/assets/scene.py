"""SceneAsset (`*.scene.json`): a tree of nodes with what hangs on them, and the scene's look.

One node a line, keys sorted, so that diffs are small. Units: metres, radians, seconds; quaternions xyzw; lights in
candela (point, spot), lux (directional) or nit (rectangle, disk); colours scene-linear Rec.709.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

IDENTITY_ROTATION = (0.0, 0.0, 0.0, 1.0)


@dataclass(slots=True)
class CameraAsset:
    """`perspective` with `yfov` (radians) or `orthographic` with `ymag` (half height, metres). zfar 0 = infinite."""

    type: str = "perspective"
    yfov: float = 0.7853981633974483
    ymag: float = 1.0
    znear: float = 0.05
    zfar: float = 0.0
    aspect: float = 0.0


@dataclass(slots=True)
class LightAsset:
    """`directional` (intensity in lux), `point` or `spot` (candela), `rectangle` or `disk` (nit = candela per square
    metre), shining along the node's local -Z. The node's scale changes none of it.

    `width`, `height` (metres) are those of a rectangle along the node's X and Y, or the diameters of a disk (an
    ellipse); `two_sided` lets it shine along +Z too. `range`: where the light ends, from the light's nearest point;
    0 = nowhere. `temperature` (kelvin, 0 = none) multiplies the colour by that of a black body of the same luminance.
    `profile`: path of an IES file, relative to the scene file, that shapes a point or spot light; `intensity` is
    then the candela where the profile is brightest. `casts_shadow`: things hide its light (the first directional one
    always casts, the others never). `radius` (metres): of what shines in a point or spot light; it softens shadows and
    changes nothing else.
    """

    type: str = "directional"
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    intensity: float = 1.0
    range: float = 0.0
    inner_angle: float = 0.0
    outer_angle: float = 0.7853981633974483
    width: float = 1.0
    height: float = 1.0
    two_sided: bool = False
    temperature: float = 0.0
    profile: str = ""
    casts_shadow: bool = False
    radius: float = 0.0


@dataclass(slots=True)
class MeshRef:
    """`file` holds the mesh named `name` (its index decides where names repeat); one material path per slot.

    An empty material path means the source named none: the default material. `overrides`: by slot, parameters of the
    material that are other on this object."""

    file: str
    index: int
    name: str = ""
    materials: list[str] = field(default_factory=list)
    overrides: list[dict[str, Any]] = field(default_factory=list)


@dataclass(slots=True)
class NodeAsset:
    """`parent` is an index before this node's own, or -1."""

    name: str
    parent: int = -1
    translation: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = IDENTITY_ROTATION
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    #: column-major f8[16] where the source's matrix is no TRS (shear); then TRS above is its best fit
    matrix: tuple[float, ...] | None = None
    visible: bool = True
    mesh: MeshRef | None = None
    camera: CameraAsset | None = None
    light: LightAsset | None = None
    #: indices of joint nodes for a skinned mesh
    joints: list[int] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)
    #: the number that clips know it by where that is not its index (see clip_nodes); -1: no clip moves it
    clip_node: int | None = None
    #: clips move it from where it stands, as they move the first node of its number from where that stands
    placed: bool = False
    extras: dict[str, object] = field(default_factory=dict)


@dataclass(slots=True)
class EnvironmentAsset:
    """The light from all around. `kind`: `sky` (procedural, by `sun_elevation`, `sun_azimuth`, `turbidity`),
    `studio` (procedural soft boxes), `uniform` (`color`), `image` (`path` to .hdr/.exr or a baked .dds cube), `none`.

    `intensity` scales it; `rotation` turns it about +Y (radians). `background`: show it behind the scene, or `color`.
    `sun_illuminance` (lux-like, scene units) is the directional light that comes with it; 0 = none.
    """

    kind: str = "studio"
    path: str = ""
    color: tuple[float, float, float] = (1.0, 1.0, 1.0)
    intensity: float = 1.0
    rotation: float = 0.0
    background: str = "environment"
    background_color: tuple[float, float, float] = (0.05, 0.05, 0.06)
    background_blur: float = 0.75
    sun_elevation: float = 0.7853981633974483
    sun_azimuth: float = 0.6
    sun_illuminance: float = 1.2
    turbidity: float = 3.0


@dataclass(slots=True)
class LookAsset:
    """Exposure in EV (0 = scene values as they are), tone map: agx | aces | neutral | none."""

    exposure: float = 0.0
    tone_map: str = "neutral"


@dataclass(slots=True)
class BookmarkAsset:
    """A place to look from: `distance` metres from `target`, turned Ry(yaw) Rx(pitch) Rz(roll) (radians)."""

    number: int = 1
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    distance: float = 5.0
    yfov: float = 0.7853981633974483
    orthographic: bool = False


@dataclass(slots=True)
class SceneAsset:
    name: str
    nodes: list[NodeAsset] = field(default_factory=list)
    clips: list[str] = field(default_factory=list)
    environment: EnvironmentAsset = field(default_factory=EnvironmentAsset)
    look: LookAsset = field(default_factory=LookAsset)
    #: index of the node whose camera is used, or -1: frame the scene
    active_camera: int = -1
    #: what it was made from: {"source": name, "source_hash": …, "importer": …}
    provenance: dict[str, str] = field(default_factory=dict)
    #: path of an animation file that poses it, relative to the scene file
    animation: str = ""
    #: what of the animation poses it when it is opened: clips | timeline | states; "" = what the file has
    drive: str = ""
    #: places to look from that somebody wants to come back to; their numbers differ
    bookmarks: list[BookmarkAsset] = field(default_factory=list)
