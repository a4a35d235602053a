"""`.mesh.xml`, the XML twin of `.mesh`.

Source: Ogre's ogremeshxml.dtd (elements and attributes) and what OgreXMLConverter writes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from engine.core.findings import Findings
from importers.ogre.data import (
    Assignments,
    Floats,
    Geometry,
    MorphKey,
    OgreMesh,
    Pose,
    PoseKey,
    SubMesh,
    VertexAnimation,
    VertexTrack,
)
from importers.ogre.xml_reader import Attributes, XmlReader, floats_of

_OPERATIONS = {"point_list": 1, "line_list": 2, "line_strip": 3, "triangle_list": 4, "triangle_strip": 5,
               "triangle_fan": 6}  # fmt: skip
_SKIPPED = {"levelofdetail": "levels of detail", "extremes": "extreme points"}


@dataclass(slots=True)
class _Columns:
    """The numbers of one geometry, as text and in order; `uv` by set, each with its number of components."""

    count: int
    position: list[str] = field(default_factory=list)
    normal: list[str] = field(default_factory=list)
    tangent: list[str] = field(default_factory=list)
    tangent_width: int = 3
    color: list[str] = field(default_factory=list)
    uv: list[list[str]] = field(default_factory=list)
    first_uv: int = 0
    next_uv: int = 0
    other: set[str] = field(default_factory=set)


def read_mesh_xml(data: bytes, file: str, findings: Findings) -> OgreMesh:
    """The mesh in `data`. Raises FormatError with the line."""
    return _MeshXml(file, findings).read(data)


class _MeshXml:
    def __init__(self, file: str, findings: Findings) -> None:
        self._xml = XmlReader(file)
        self._findings = findings
        self._mesh = OgreMesh("XML")
        self._columns: _Columns | None = None
        self._part: SubMesh | None = None
        self._indices: list[str] = []
        self._bones: tuple[list[str], list[str], list[str]] = ([], [], [])
        self._pose: tuple[str, int] | None = None
        self._pose_rows: list[str] = []
        self._pose_normals: list[str] = []
        self._pose_vertices: list[str] = []
        self._track: VertexTrack | None = None
        self._key: tuple[float, list[str], list[str]] | None = None
        self._names: dict[int, str] = {}

    def read(self, data: bytes) -> OgreMesh:
        xml = self._xml
        xml.starts = {
            "sharedgeometry": self._start_geometry, "geometry": self._start_geometry, "vertex": self._vertex,
            "vertexbuffer": self._buffer, "position": self._position, "normal": self._normal,
            "tangent": self._tangent, "binormal": self._ignored("binormal"), "colour_diffuse": self._colour,
            "colour_specular": self._ignored("specular colour"), "texcoord": self._texcoord,
            "submesh": self._start_submesh, "face": self._face, "texture": self._texture,
            "vertexboneassignment": self._assignment, "skeletonlink": self._skeleton, "submeshname": self._name,
            "pose": self._start_pose, "poseoffset": self._offset, "animation": self._animation,
            "baseinfo": self._base, "track": self._start_track, "keyframe": self._start_key, "poseref": self._poseref,
            **{name: self._skip(what) for name, what in _SKIPPED.items()},
        }  # fmt: skip
        xml.ends = {
            "sharedgeometry": self._end_shared, "geometry": self._end_geometry, "submesh": self._end_submesh,
            "boneassignments": self._end_assignments, "pose": self._end_pose, "keyframe": self._end_key,
            "track": self._end_track,
        }  # fmt: skip
        xml.parse(data)
        if not self._mesh.submeshes:
            raise xml.error("the file holds no submesh")
        for index, name in self._names.items():
            if index < len(self._mesh.submeshes):
                self._mesh.submeshes[index].name = name
        return self._mesh

    def _skip(self, what: str) -> Callable[[Attributes], None]:
        return lambda _: self._mesh.skip(what)

    def _ignored(self, what: str) -> Callable[[Attributes], None]:
        def note(_: Attributes) -> None:
            if self._columns is not None:
                self._columns.other.add(what)

        return note

    # --- vertices ---

    def _start_geometry(self, a: Attributes) -> None:
        self._columns = _Columns(self._xml.whole(a, "vertexcount"))

    def _buffer(self, _: Attributes) -> None:
        if self._columns is not None:
            self._columns.first_uv = len(self._columns.uv)

    def _vertex(self, _: Attributes) -> None:
        if self._columns is not None:
            self._columns.next_uv = self._columns.first_uv

    def _position(self, a: Attributes) -> None:
        into = self._columns.position if self._columns is not None else self._key[1] if self._key is not None else None
        if into is not None:
            into += (a["x"], a["y"], a["z"])

    def _normal(self, a: Attributes) -> None:
        into = self._columns.normal if self._columns is not None else self._key[2] if self._key is not None else None
        if into is not None:
            into += (a["x"], a["y"], a["z"])

    def _tangent(self, a: Attributes) -> None:
        if self._columns is not None:
            self._columns.tangent += (a["x"], a["y"], a["z"], a.get("w", "1"))

    def _colour(self, a: Attributes) -> None:
        if self._columns is not None:
            words = a["value"].split()
            self._columns.color += (words + ["1"] * 4)[:4] if len(words) >= 3 else ["nan"] * 4

    def _texcoord(self, a: Attributes) -> None:
        columns = self._columns
        if columns is None:
            return
        if columns.next_uv == len(columns.uv):
            columns.uv.append([])
        columns.uv[columns.next_uv] += (a["u"], a.get("v", "0"))
        columns.next_uv += 1

    def _end_shared(self) -> None:
        self._mesh.shared = self._geometry("the shared geometry")

    def _end_geometry(self) -> None:
        where = f"submeshes[{len(self._mesh.submeshes)}]"
        geometry = self._geometry(where)
        if self._part is not None:
            self._part.geometry = geometry

    def _geometry(self, where: str) -> Geometry:
        columns, self._columns = self._columns, None
        assert columns is not None
        position = floats_of(columns.position, 3)
        count = len(position)
        if count != columns.count:
            raise self._xml.error(f"{where} has {count:,} vertices, its vertexcount says {columns.count:,}")
        geometry = Geometry(position)

        def column(words: list[str], width: int, what: str) -> Floats | None:
            if not words:
                return None
            if len(words) != count * width:
                raise self._xml.error(f"{where} has {len(words) // width:,} {what} for {count:,} positions")
            return floats_of(words, width)

        geometry.normal = column(columns.normal, 3, "normals")
        geometry.tangent = column(columns.tangent, 4, "tangents")
        geometry.color = column(columns.color, 4, "colours")
        for number, words in enumerate(columns.uv):
            values = column(words, 2, f"coordinates of uv set {number}")
            if values is not None and number < 2:
                geometry.uv[number] = values
            elif number >= 2:
                columns.other.add(f"uv set {number}")
        for what in sorted(columns.other - {"binormal"}):
            self._findings.info("ogre.vertex-element", f"{what} is not imported", where)
        return geometry

    # --- submeshes ---

    def _start_submesh(self, a: Attributes) -> None:
        operation = a.get("operationtype", "triangle_list")
        if operation not in _OPERATIONS:
            raise self._xml.error(
                f"operationtype={operation[:40]!r} is not known", f"known are {', '.join(_OPERATIONS)}"
            )
        self._part = SubMesh(a.get("material", ""), np.zeros(0, np.uint32), operation=_OPERATIONS[operation])
        self._indices = []

    def _face(self, a: Attributes) -> None:
        # Strips and fans name three vertices first and then one each; lines two
        self._indices.append(a["v1"])
        if "v2" in a:
            self._indices.append(a["v2"])
            if "v3" in a:
                self._indices.append(a["v3"])

    def _texture(self, a: Attributes) -> None:
        if self._part is not None:
            self._part.aliases[a["alias"]] = a["name"]

    def _end_submesh(self) -> None:
        part, self._part = self._part, None
        assert part is not None
        part.indices = self._wholes(self._indices, "a face's vertex").astype(np.uint32)
        self._mesh.submeshes.append(part)

    def _wholes(self, words: list[str], what: str, top: int = 0xFFFFFFFF) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
        try:
            values = np.array(list(map(int, words)), np.int64)
        except (ValueError, OverflowError):
            raise self._xml.error(f"{what} is no whole number") from None
        if len(values) and (values.min() < 0 or values.max() > top):
            raise self._xml.error(f"{what} is outside of 0 to {top}")
        return values

    def _assignment(self, a: Attributes) -> None:
        vertices, bones, weights = self._bones
        vertices.append(a["vertexindex"])
        bones.append(a["boneindex"])
        weights.append(a.get("weight", "1"))

    def _end_assignments(self) -> None:
        vertices, bones, weights = self._bones
        self._bones = ([], [], [])
        rows = Assignments(
            self._wholes(vertices, "a vertexindex").astype(np.uint32),
            self._wholes(bones, "a boneindex", 0xFFFF).astype(np.uint16), floats_of(weights, 1).reshape(-1),
        )  # fmt: skip
        if self._part is not None:
            self._part.assignments = rows
        else:
            self._mesh.assignments = rows

    def _skeleton(self, a: Attributes) -> None:
        self._mesh.skeleton = a["name"]

    def _name(self, a: Attributes) -> None:
        self._names[self._xml.whole(a, "index")] = a["name"]

    # --- poses and vertex animation ---

    def _target(self, a: Attributes) -> int:
        if a.get("target", "mesh") == "mesh":
            return 0
        return min(self._xml.whole(a, "index"), 0xFFFE) + 1

    def _start_pose(self, a: Attributes) -> None:
        self._pose = a.get("name", ""), self._target(a)
        self._pose_vertices, self._pose_rows, self._pose_normals = [], [], []

    def _offset(self, a: Attributes) -> None:
        self._pose_vertices.append(a["index"])
        self._pose_rows += (a["x"], a["y"], a["z"])
        if "nx" in a:
            self._pose_normals += (a["nx"], a["ny"], a["nz"])

    def _end_pose(self) -> None:
        assert self._pose is not None
        (name, target), self._pose = self._pose, None
        vertices = self._wholes(self._pose_vertices, "a poseoffset's index").astype(np.uint32)
        normals = floats_of(self._pose_normals, 3) if self._pose_normals else None
        if normals is not None and len(normals) != len(vertices):
            raise self._xml.error("some offsets of the pose have normals and some have not")
        self._mesh.poses.append(Pose(name, target, vertices, floats_of(self._pose_rows, 3), normals))

    def _animation(self, a: Attributes) -> None:
        self._mesh.animations.append(VertexAnimation(a["name"], self._xml.number(a, "length")))

    def _base(self, a: Attributes) -> None:
        if self._mesh.animations:
            self._mesh.animations[-1].base = a.get("baseanimationname", "")

    def _start_track(self, a: Attributes) -> None:
        self._track = VertexTrack(self._target(a))

    def _end_track(self) -> None:
        if self._track is not None and self._mesh.animations:
            self._mesh.animations[-1].tracks.append(self._track)
        self._track = None

    def _start_key(self, a: Attributes) -> None:
        if self._track is not None:
            self._key = self._xml.number(a, "time"), [], []
            self._track.poses.append(PoseKey(self._key[0], []))

    def _poseref(self, a: Attributes) -> None:
        if self._track is not None and self._track.poses:
            self._track.poses[-1].poses.append((self._xml.whole(a, "poseindex"), self._xml.number(a, "influence", 1.0)))

    def _end_key(self) -> None:
        if self._track is None or self._key is None:
            return
        (time, positions, normals), self._key = self._key, None
        if positions:
            self._track.poses.pop()
            if normals and len(normals) != len(positions):
                raise self._xml.error("some positions of the key have normals and some have not")
            given = floats_of(normals, 3) if normals else None
            self._track.morphs.append(MorphKey(time, floats_of(positions, 3), given))
