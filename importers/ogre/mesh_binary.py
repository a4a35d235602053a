"""Binary `.mesh` files, serialiser versions 1.10 to 1.100, either endianness.

Source: Ogre manual and the comments of its OgreMeshFileFormat header (chunk ids and their order, 2000 to 2020).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from engine.core.findings import Findings
from importers.ogre.chunks import Chunks
from importers.ogre.data import (
    OPERATIONS,
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
from importers.ogre.vertices import POSITION, SEMANTICS, Buffer, Element, decode, to_geometry

MESH, SUBMESH, OPERATION, SUBMESH_ASSIGNMENT, ALIAS = 0x3000, 0x4000, 0x4010, 0x4100, 0x4200
GEOMETRY, DECLARATION, ELEMENT, BUFFER, BUFFER_DATA = 0x5000, 0x5100, 0x5110, 0x5200, 0x5210
SKELETON_LINK, ASSIGNMENT, BOUNDS, NAME_TABLE, NAME = 0x6000, 0x7000, 0x9000, 0xA000, 0xA100
POSES, POSE, POSE_VERTEX = 0xC000, 0xC100, 0xC111
ANIMATIONS, ANIMATION, BASE, TRACK, MORPH_KEY, POSE_KEY, POSE_REF = (
    0xD000, 0xD100, 0xD105, 0xD110, 0xD111, 0xD112, 0xD113,
)  # fmt: skip
#: what is known and left out
SKIPPED = {
    0x8000: "levels of detail", 0x8100: "levels of detail", 0x8110: "levels of detail", 0x8120: "levels of detail",
    0xB000: "edge lists", 0xB100: "edge lists", 0xB110: "edge lists", 0xE000: "extreme points",
}  # fmt: skip
_ASSIGNMENT_BODY = [("vertex", "u4"), ("bone", "u2"), ("weight", "f4")]
#: as the header says it -> the serialiser's number ("1.100" is ten, after 1.8)
VERSIONS = {"1.10": 1, "1.20": 2, "1.30": 3, "1.40": 4, "1.41": 4, "1.8": 8, "1.100": 10}


def read_mesh(data: bytes, file: str, findings: Findings) -> OgreMesh:
    """The mesh in `data`. Raises FormatError (with the byte) where it is cut or breaks the format."""
    return _MeshReader(Chunks(data, file), findings).read()


class _MeshReader:
    def __init__(self, chunks: Chunks, findings: Findings) -> None:
        self._in = chunks
        self._findings = findings
        self._version = 10
        self._mesh = OgreMesh("")

    def read(self) -> OgreMesh:
        c = self._in
        line = c.header("an Ogre mesh")
        name, _, number = line.rpartition("_v")
        if name != "MeshSerializer" or number not in VERSIONS:
            raise c.error(
                f"the version {line[:60]!r} is not known", f"known are MeshSerializer_v{', v'.join(VERSIONS)}", 2
            )
        self._version = VERSIONS[number]
        self._mesh.version = number
        while (found := c.next_id()) >= 0:
            if found == MESH:
                c.enter("the mesh")
                c.flag("the mesh's skeleton flag")
                self._members()
            else:
                self._skip(found)
        if not self._mesh.submeshes:
            raise c.error("the file holds no submesh")
        return self._mesh

    def _members(self) -> None:
        c, mesh = self._in, self._mesh
        readers: dict[int, Callable[[], None]] = {
            SUBMESH: self._submesh, SKELETON_LINK: self._skeleton_link, BOUNDS: self._bounds,
            NAME_TABLE: self._names, POSES: self._poses, ANIMATIONS: self._animations,
        }  # fmt: skip
        while (found := c.next_id()) >= 0 and found != MESH:
            if found == GEOMETRY:
                if mesh.shared is not None:
                    raise c.error("a second shared geometry")
                mesh.shared = self._geometry("the shared geometry")
            elif found == ASSIGNMENT:
                mesh.assignments = self._assignments(ASSIGNMENT, mesh.assignments)
            elif found in readers:
                readers[found]()
            else:
                self._skip(found)

    def _skip(self, found: int) -> None:
        what = SKIPPED.get(found)
        if what is None:
            self._findings.warn(
                "ogre.chunk", f"the unknown chunk 0x{found:04X} is left out", f"byte {self._in.position:,}"
            )
        else:
            self._mesh.skip(what)
        self._in.skip(what or "an unknown chunk")

    def _skeleton_link(self) -> None:
        self._in.enter("the skeleton link")
        self._mesh.skeleton = self._in.text("the skeleton's name")

    def _bounds(self) -> None:
        self._in.enter("the bounds")
        # Worked out anew from the vertices; exporters pad them.
        self._in.take(28, "the bounds")

    def _names(self) -> None:
        c = self._in
        c.enter("the name table")
        while c.next_id() == NAME:
            c.enter("a submesh's name")
            index, name = c.u16("a submesh's number"), c.text("a submesh's name")
            if index < len(self._mesh.submeshes):
                self._mesh.submeshes[index].name = name

    # --- submeshes and vertices ---

    def _submesh(self) -> None:
        c, number = self._in, len(self._mesh.submeshes)
        where = f"submeshes[{number}]"
        c.enter(where)
        material = c.text(f"{where}'s material name")
        shared = c.flag(where)
        count = c.u32(f"{where}'s index count")
        wide = c.flag(where)
        indices = c.array("u4" if wide else "u2", count, f"{where}'s {count:,} indices").astype(np.uint32)
        part = SubMesh(material, indices)
        if not shared:
            part.geometry = self._geometry(where)
        while True:
            found = c.next_id()
            if found == OPERATION:
                c.enter(where)
                part.operation = c.u16(f"{where}'s operation type")
                if part.operation not in OPERATIONS:
                    raise c.error(f"{where} has the operation type {part.operation}; known are 1 to 6")
            elif found == SUBMESH_ASSIGNMENT:
                part.assignments = self._assignments(SUBMESH_ASSIGNMENT, part.assignments)
            elif found == ALIAS:
                c.enter(where)
                alias = c.text(f"{where}'s texture alias")
                part.aliases[alias] = c.text(f"{where}'s texture alias")
            else:
                break
        self._mesh.submeshes.append(part)

    def _assignments(self, number: int, before: Assignments) -> Assignments:
        rows = self._in.records(number, _ASSIGNMENT_BODY, "a bone assignment")
        return Assignments(
            np.concatenate([before.vertex, rows["vertex"]]), np.concatenate([before.bone, rows["bone"]]),
            np.concatenate([before.weight, rows["weight"]]),
        )  # fmt: skip

    def _geometry(self, where: str) -> Geometry:
        c = self._in
        c.expect(GEOMETRY, f"the geometry of {where}")
        count = c.u32(f"the vertex count of {where}")
        if self._version < 3:
            return self._old_geometry(count, where)
        elements: list[Element] = []
        columns: dict[tuple[int, int], tuple[Element, Floats]] = {}
        while (found := c.next_id()) in (DECLARATION, BUFFER):
            c.enter(where)
            if found == DECLARATION:
                while c.next_id() == ELEMENT:
                    c.enter(where)
                    elements.append(Element(*(c.u16(f"a vertex element of {where}") for _ in range(5))))
            else:
                self._buffer(count, elements, columns, where)
        if (POSITION, 0) not in columns:
            raise c.error(f"{where} has no positions")
        return to_geometry(columns, self._findings, where)

    def _buffer(
        self,
        count: int,
        elements: list[Element],
        columns: dict[tuple[int, int], tuple[Element, Floats]],
        where: str,
    ) -> None:
        c, start = self._in, self._in.chunk_start
        source, stride = c.u16(f"a vertex buffer of {where}"), c.u16(f"a vertex buffer of {where}")
        c.expect(BUFFER_DATA, f"the data of vertex buffer {source} of {where}")
        own = [e for e in elements if e.source == source]
        unknown = [e.type for e in own if e.size < 0]
        if unknown:
            raise c.error(f"{where} has vertex elements of the unknown type {unknown[0]}", at=start)
        declared = max((e.offset + e.size for e in own), default=0)
        if declared != stride:
            last = max(own, key=lambda e: e.offset + e.size, default=None)
            what = SEMANTICS.get(last.semantic, f"semantic {last.semantic}") if last else "nothing"
            raise c.error(
                f"vertex buffer {source} of {where} has {stride} bytes a vertex, its declaration {declared} "
                f"(to the end of {what})", "the mesh's exporter was at fault: export it again", start,
            )  # fmt: skip
        data = c.take(count * stride, f"vertex buffer {source} of {where} with {count:,} vertices of {stride} bytes")
        buffer = Buffer(data, stride, c.order)
        for element in own:
            columns[element.semantic, element.index] = element, decode(element, buffer, count)

    def _old_geometry(self, count: int, where: str) -> Geometry:
        """Versions 1.10 and 1.20: positions, then chunks of normals, colours and uv sets, each of its own."""
        c = self._in
        geometry = Geometry(c.array("f4", count * 3, f"{where}'s {count:,} positions").reshape(count, 3))
        number = 0
        while (found := c.next_id()) in (0x5100, 0x5200, 0x5300):
            c.enter(where)
            if found == 0x5100:
                geometry.normal = c.array("f4", count * 3, f"{where}'s normals").reshape(count, 3)
            elif found == 0x5200:
                packed = c.array("u4", count, f"{where}'s colours")
                channels = np.stack([(packed >> s) & 0xFF for s in (24, 16, 8, 0)], 1)
                geometry.color = channels.astype(np.float32) / np.float32(255)
            else:
                width = c.u16(f"{where}'s uv set {number}")
                values = c.array("f4", count * width, f"{where}'s uv set {number}").reshape(count, width)
                if number < 2 and width >= 1:
                    uv = np.zeros((count, 2), np.float32)
                    uv[:, : min(width, 2)] = values[:, :2]
                    if self._version == 1 and width == 2:
                        # version 1.10 put the origin at the bottom left
                        uv[:, 1] = 1 - uv[:, 1]
                    geometry.uv[number] = uv
                number += 1
        return geometry

    # --- poses and vertex animation ---

    def _target_count(self, target: int) -> int:
        mesh = self._mesh
        if target == 0:
            return mesh.shared.count if mesh.shared is not None else 0
        part = mesh.submeshes[target - 1] if target <= len(mesh.submeshes) else None
        return part.geometry.count if part is not None and part.geometry is not None else 0

    def _poses(self) -> None:
        c = self._in
        c.enter("the poses")
        while c.next_id() == POSE:
            c.enter("a pose")
            where = f"poses[{len(self._mesh.poses)}]"
            name, target = c.text(f"{where}'s name"), c.u16(f"{where}'s target")
            normals = self._version >= 8 and c.flag(where)
            body: list[Any] = [("vertex", "u4"), ("offset", "f4", 3), *([("normal", "f4", 3)] if normals else [])]
            pose = Pose(name, target, np.zeros(0, np.uint32), np.zeros((0, 3), np.float32))
            if c.next_id() == POSE_VERTEX:
                rows = c.records(POSE_VERTEX, body, f"a vertex of {where}")
                pose.vertices, pose.offsets = rows["vertex"].copy(), rows["offset"].copy()
                pose.normals = rows["normal"].copy() if normals else None
            self._mesh.poses.append(pose)

    def _animations(self) -> None:
        c = self._in
        c.enter("the animations")
        while c.next_id() == ANIMATION:
            c.enter("an animation")
            where = f"animations[{len(self._mesh.animations)}]"
            animation = VertexAnimation(c.text(f"{where}'s name"), c.floats(1, f"{where}'s length")[0])
            if c.next_id() == BASE:
                c.enter(where)
                animation.base = c.text(f"{where}'s base")
                c.floats(1, f"{where}'s base time")
            while c.next_id() == TRACK:
                c.enter(where)
                animation.tracks.append(self._track(f"{where}.tracks[{len(animation.tracks)}]"))
            self._mesh.animations.append(animation)

    def _track(self, where: str) -> VertexTrack:
        c = self._in
        c.u16(f"the kind of {where}")
        track = VertexTrack(c.u16(f"the target of {where}"))
        count = self._target_count(track.target)
        while (found := c.next_id()) in (MORPH_KEY, POSE_KEY):
            c.enter(where)
            time = c.floats(1, f"a key time of {where}")[0]
            if found == MORPH_KEY:
                normals = self._version >= 8 and c.flag(where)
                width = 6 if normals else 3
                if not count:
                    raise c.error(f"{where} moves the target {track.target}, which has no vertices")
                values = c.array("f4", count * width, f"a key of {where}")
                # positions of all vertices, each followed by its normal where there are normals
                rows = values.reshape(count, width)
                track.morphs.append(MorphKey(time, rows[:, :3].copy(), rows[:, 3:].copy() if normals else None))
            else:
                key = PoseKey(time, [])
                while c.next_id() == POSE_REF:
                    c.enter(where)
                    key.poses.append((c.u16(f"a pose of {where}"), c.floats(1, f"an influence in {where}")[0]))
                track.poses.append(key)
        return track
