"""Small Ogre files made by hand: binary chunks of either endianness, and their XML twins."""

from __future__ import annotations

import struct
from collections.abc import Sequence

#: a square in the XY plane, two triangles, counter-clockwise seen from +Z
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
SQUARE_UV = [(0, 1), (1, 1), (1, 0), (0, 0)]
SQUARE_INDICES = [0, 1, 2, 0, 2, 3]


class OgreBytes:
    """Builds chunks; `order` is '<' or '>'."""

    def __init__(self, order: str = "<") -> None:
        self.order = order

    def pack(self, layout: str, *values: float) -> bytes:
        return struct.pack(self.order + layout, *values)

    def chunk(self, number: int, *body: bytes, length: int | None = None) -> bytes:
        data = b"".join(body)
        return self.pack("HI", number, 6 + len(data) if length is None else length) + data

    def text(self, value: str) -> bytes:
        return value.encode() + b"\n"

    def header(self, version: str) -> bytes:
        return self.pack("H", 0x1000) + self.text(f"[{version}]")

    def geometry(self, count: int, buffers: Sequence[tuple[Sequence[tuple[int, int, int]], bytes]]) -> bytes:
        """`buffers`: ((type, semantic, index) …, data) each; offsets follow from the types' sizes below."""
        sizes = {0: 4, 1: 8, 2: 12, 3: 16, 4: 4, 5: 2, 6: 4, 7: 6, 8: 8, 9: 4, 10: 4, 11: 4, 13: 16, 14: 24, 17: 4,
                 29: 4, 30: 4, 31: 4, 32: 8, 33: 4, 34: 8, 35: 4, 37: 4, 38: 6, 39: 8}  # fmt: skip
        elements, data = b"", b""
        for source, (declared, raw) in enumerate(buffers):
            offset = 0
            for kind, semantic, index in declared:
                elements += self.chunk(0x5110, self.pack("5H", source, kind, semantic, offset, index))
                offset += sizes[kind]
            body = self.chunk(0x5210, raw)
            data += self.chunk(0x5200, self.pack("HH", source, offset), body)
        return self.chunk(0x5000, self.pack("I", count), self.chunk(0x5100, elements), data)

    def submesh(
        self, material: str, indices: Sequence[int], geometry: bytes | None = None, operation: int = 4,
        assignments: Sequence[tuple[int, int, float]] = (), extra: bytes = b"", wide: bool = False,
    ) -> bytes:  # fmt: skip
        kind = "I" if wide else "H"
        return self.chunk(
            0x4000, self.text(material), self.pack("?", geometry is None), self.pack("I?", len(indices), wide),
            self.pack(f"{len(indices)}{kind}", *indices), geometry or b"",
            self.chunk(0x4010, self.pack("H", operation)), extra,
            *(self.chunk(0x4100, self.pack("IHf", *row)) for row in assignments),
        )  # fmt: skip

    def mesh(self, *members: bytes, version: str = "MeshSerializer_v1.100") -> bytes:
        return self.header(version) + self.chunk(0x3000, self.pack("?", True), *members)

    def square_geometry(self, normals: bool = True) -> bytes:
        declared = [(2, 1, 0), *([(2, 4, 0)] if normals else []), (1, 7, 0)]
        raw = b"".join(
            self.pack("3f", *p) + (self.pack("3f", 0, 0, 1) if normals else b"") + self.pack("2f", *uv)
            for p, uv in zip(SQUARE, SQUARE_UV, strict=True)
        )
        return self.geometry(4, [(declared, raw)])

    def square(self, material: str = "Test", **rest: object) -> bytes:
        """A whole mesh: the square, with a geometry of its own."""
        return self.mesh(self.submesh(material, SQUARE_INDICES, self.square_geometry(), **rest))  # type: ignore[arg-type]  # passed through

    # --- skeletons ---

    def bone(
        self, name: str, handle: int, position: Sequence[float] = (0, 0, 0),
        rotation: Sequence[float] = (0, 0, 0, 1), scale: Sequence[float] | None = None,
    ) -> bytes:  # fmt: skip
        body = self.pack("H7f", handle, *position, *rotation) + (self.pack("3f", *scale) if scale else b"")
        # the length leaves the name out
        return self.chunk(0x2000, self.text(name), body, length=6 + len(body))

    def parent(self, child: int, parent: int) -> bytes:
        return self.chunk(0x3000, self.pack("HH", child, parent))

    def key(
        self, time: float, rotation: Sequence[float] = (0, 0, 0, 1), translation: Sequence[float] = (0, 0, 0),
        scale: Sequence[float] | None = None,
    ) -> bytes:  # fmt: skip
        return self.chunk(
            0x4110, self.pack("f7f", time, *rotation, *translation), self.pack("3f", *scale) if scale else b""
        )

    def animation(self, name: str, length: float, tracks: Sequence[tuple[int, Sequence[bytes]]]) -> bytes:
        body = b"".join(self.chunk(0x4100, self.pack("H", bone), *keys) for bone, keys in tracks)
        return self.chunk(0x4000, self.text(name), self.pack("f", length), body)

    def skeleton(self, *members: bytes) -> bytes:
        return self.header("Serializer_v1.10") + b"".join(members)


MORPH_XML = """<mesh>
 <sharedgeometry vertexcount="3">
  <vertexbuffer positions="true" normals="true" colours_diffuse="true" texture_coords="2"
    texture_coord_dimensions_0="float2" texture_coord_dimensions_1="float2">
   <vertex><position x="0" y="0" z="0"/><normal x="0" y="0" z="1"/><colour_diffuse value="1 0 0 1"/>
     <texcoord u="0" v="0"/><texcoord u="0.5" v="0.25"/></vertex>
   <vertex><position x="1" y="0" z="0"/><normal x="0" y="0" z="1"/><colour_diffuse value="0 1 0 1"/>
     <texcoord u="1" v="0"/><texcoord u="0.5" v="0.5"/></vertex>
   <vertex><position x="0" y="1" z="0"/><normal x="0" y="0" z="1"/><colour_diffuse value="0 0 1 0.2"/>
     <texcoord u="0" v="1"/><texcoord u="0.5" v="0.75"/></vertex>
  </vertexbuffer>
 </sharedgeometry>
 <submeshes>
  <submesh material="A" usesharedvertices="true" use32bitindexes="false" operationtype="triangle_list">
   <faces count="1"><face v1="0" v2="1" v3="2"/></faces>
  </submesh>
  <submesh material="B" usesharedvertices="false" use32bitindexes="true" operationtype="triangle_strip">
   <faces count="2"><face v1="0" v2="1" v3="2"/><face v1="3"/></faces>
   <geometry vertexcount="4">
    <vertexbuffer positions="true" normals="true">
     <vertex><position x="0" y="0" z="1"/><normal x="0" y="0" z="1"/></vertex>
     <vertex><position x="1" y="0" z="1"/><normal x="0" y="0" z="1"/></vertex>
     <vertex><position x="0" y="1" z="1"/><normal x="0" y="0" z="1"/></vertex>
     <vertex><position x="1" y="1" z="1"/><normal x="0" y="0" z="1"/></vertex>
    </vertexbuffer>
   </geometry>
  </submesh>
 </submeshes>
 <submeshnames><submeshname name="first" index="0"/><submeshname name="second" index="1"/></submeshnames>
 <poses>
  <pose target="mesh" name="up"><poseoffset index="1" x="0" y="2" z="0"/>
    <poseoffset index="2" x="0" y="1" z="0"/></pose>
  <pose target="mesh" name="side"><poseoffset index="0" x="-1" y="0" z="0"/></pose>
 </poses>
 <animations>
  <animation name="talk" length="2">
   <tracks>
    <track target="mesh" type="pose">
     <keyframes>
      <keyframe time="0"><poseref poseindex="0" influence="0.5"/></keyframe>
      <keyframe time="1"><poseref poseindex="0" influence="1"/><poseref poseindex="1" influence="0.25"/></keyframe>
      <keyframe time="2"/>
     </keyframes>
    </track>
    <track target="submesh" index="1" type="morph">
     <keyframes>
      <keyframe time="0"><position x="0" y="0" z="1"/><position x="1" y="0" z="1"/><position x="0" y="1" z="1"/>
        <position x="1" y="1" z="1"/></keyframe>
      <keyframe time="0.5"><position x="0" y="0" z="3"/><position x="1" y="0" z="3"/><position x="0" y="1" z="3"/>
        <position x="1" y="1" z="3"/></keyframe>
      <keyframe time="2"><position x="0" y="0" z="2"/><position x="1" y="0" z="2"/><position x="0" y="1" z="2"/>
        <position x="1" y="1" z="2"/></keyframe>
     </keyframes>
    </track>
   </tracks>
  </animation>
 </animations>
</mesh>
"""


def rigged(b: OgreBytes) -> tuple[bytes, bytes]:
    rows = [(v, v % 2, 1.0) for v in range(4)]
    link, lod = b.chunk(0x6000, b.text("t.skeleton")), b.chunk(0x8000, bytes(20))
    pose = b.chunk(0xC100, b.text("p"), b.pack("H?", 1, False), b.chunk(0xC111, b.pack("I3f", 1, 0, 1, 0)))
    key = b.chunk(0xD112, b.pack("f", 0.5), b.chunk(0xD113, b.pack("Hf", 0, 1)))
    animation = b.chunk(0xD000, b.chunk(0xD100, b.text("a"), b.pack("f", 1), b.chunk(0xD110, b.pack("HH", 2, 1), key)))
    part = b.submesh("m", SQUARE_INDICES, b.square_geometry(), assignments=rows)
    mesh = b.mesh(part, link, lod, b.chunk(0xC000, pose), animation)
    tracks = [(0, [b.key(0), b.key(0.5, translation=(1, 0, 0))]), (1, [b.key(0), b.key(1, scale=(2, 2, 2))])]
    skeleton = b.skeleton(b.bone("a", 0), b.bone("b", 1, (0, 1, 0)), b.parent(1, 0), b.animation("walk", 1, tracks))
    return mesh, skeleton
