"""Small files of other formats, written by hand, with everything known about them."""

from __future__ import annotations

from pathlib import Path

#: a box of 2 x 4 x 6 about the origin: corners, and quads wound counter-clockwise seen from outside
CORNERS = [(x, y, z) for x in (-1.0, 1.0) for y in (-2.0, 2.0) for z in (-3.0, 3.0)]
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def obj(folder: Path, *, mtl: str = "box.mtl") -> Path:
    """The box as two objects of three quads with two materials, one with a texture, and uvs."""
    lines = [f"mtllib {mtl}"] + [f"v {x} {y} {z}" for x, y, z in CORNERS] + ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    for half, name in enumerate(("left", "right")):
        lines += [f"o {name}", f"usemtl {name}"]
        for quad in QUADS[half * 3 : half * 3 + 3]:
            lines.append("f " + " ".join(f"{v + 1}/{k + 1}" for k, v in enumerate(quad)))
    (folder / "box.obj").write_text("\n".join(lines) + "\n")
    (folder / "box.mtl").write_text(
        "newmtl left\nKd 0.2 0.4 0.6\nd 0.5\n"
        "newmtl right\nKd 1 1 1\nKe 0.5 0 0\nNs 98\nKs 1 1 1\nmap_Kd skin.png\nmap_Bump skin_normal.png\n"
    )
    return folder / "box.obj"


def stl(folder: Path) -> Path:
    triangles = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
    lines = ["solid box"]
    for triangle in triangles:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex {} {} {}".format(*CORNERS[v]) for v in triangle] + ["endloop", "endfacet"]
    (folder / "box.stl").write_text("\n".join([*lines, "endsolid box", ""]))
    return folder / "box.stl"


def ply(folder: Path) -> Path:
    """With vertex colours: red where x is positive, else mid grey (sRGB 188 is half the light)."""
    lines = ["ply", "format ascii 1.0", f"element vertex {len(CORNERS)}"]
    lines += [f"property float {c}" for c in "xyz"] + [f"property uchar {c}" for c in ("red", "green", "blue")]
    lines += [f"element face {len(QUADS)}", "property list uchar int vertex_indices", "end_header"]
    lines += [f"{x} {y} {z} {'255 0 0' if x > 0 else '188 188 188'}" for x, y, z in CORNERS]
    lines += ["4 " + " ".join(map(str, quad)) for quad in QUADS]
    (folder / "box.ply").write_text("\n".join(lines) + "\n")
    return folder / "box.ply"


def off(folder: Path) -> Path:
    lines = ["OFF", f"{len(CORNERS)} {len(QUADS)} 0"] + ["{} {} {}".format(*c) for c in CORNERS]
    lines += ["4 " + " ".join(map(str, quad)) for quad in QUADS]
    (folder / "box.off").write_text("\n".join(lines) + "\n")
    return folder / "box.off"


def dae(folder: Path) -> Path:
    """A concave pentagon of centimetres with Z up, skinned to a joint that turns by 90 degrees about Z within 1 s."""
    turn = "0 -1 0 0 1 0 0 0 0 0 1 0 0 0 0 1"
    unit = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"
    (folder / "bend.dae").write_text(f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis></asset>
<library_effects><effect id="paint-fx"><profile_COMMON><technique sid="t"><phong>
<diffuse><color>0.8 0.1 0.1 1</color></diffuse></phong></technique></profile_COMMON></effect></library_effects>
<library_materials><material id="paint" name="paint"><instance_effect url="#paint-fx"/></material></library_materials>
<library_geometries><geometry id="g" name="arrow"><mesh>
<source id="g-p"><float_array id="g-pa" count="15">0 0 0 100 -100 0 50 0 0 100 100 0 0 50 0</float_array>
<technique_common><accessor source="#g-pa" count="5" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="g-v"><input semantic="POSITION" source="#g-p"/></vertices>
<polylist count="1" material="m"><input semantic="VERTEX" source="#g-v" offset="0"/><vcount>5</vcount>
<p>1 2 3 4 0</p></polylist></mesh></geometry></library_geometries>
<library_controllers><controller id="c"><skin source="#g"><bind_shape_matrix>{unit}</bind_shape_matrix>
<source id="c-j"><Name_array id="c-ja" count="1">bone</Name_array><technique_common><accessor source="#c-ja" count="1"
stride="1"><param name="JOINT" type="name"/></accessor></technique_common></source>
<source id="c-b"><float_array id="c-ba" count="16">{unit}</float_array><technique_common><accessor source="#c-ba"
count="1" stride="16"><param name="TRANSFORM" type="float4x4"/></accessor></technique_common></source>
<source id="c-w"><float_array id="c-wa" count="1">1</float_array><technique_common><accessor source="#c-wa" count="1"
stride="1"><param name="WEIGHT" type="float"/></accessor></technique_common></source>
<joints><input semantic="JOINT" source="#c-j"/><input semantic="INV_BIND_MATRIX" source="#c-b"/></joints>
<vertex_weights count="5"><input semantic="JOINT" source="#c-j" offset="0"/><input semantic="WEIGHT" source="#c-w"
offset="1"/><vcount>1 1 1 1 1</vcount><v>0 0 0 0 0 0 0 0 0 0</v></vertex_weights></skin></controller>
</library_controllers>
<library_animations><animation id="a"><source id="a-t"><float_array id="a-ta" count="2">0 1</float_array>
<technique_common><accessor source="#a-ta" count="2" stride="1"><param name="TIME" type="float"/></accessor>
</technique_common></source><source id="a-v"><float_array id="a-va" count="32">{unit} {turn}</float_array>
<technique_common><accessor source="#a-va" count="2" stride="16"><param name="TRANSFORM" type="float4x4"/></accessor>
</technique_common></source><source id="a-i"><Name_array id="a-ia" count="2">LINEAR LINEAR</Name_array>
<technique_common><accessor source="#a-ia" count="2" stride="1"><param name="INTERPOLATION" type="name"/></accessor>
</technique_common></source><sampler id="a-s"><input semantic="INPUT" source="#a-t"/><input semantic="OUTPUT"
source="#a-v"/><input semantic="INTERPOLATION" source="#a-i"/></sampler><channel source="#a-s"
target="bone/transform"/></animation></library_animations>
<library_visual_scenes><visual_scene id="s" name="s"><node id="bone" sid="bone" name="bone" type="JOINT">
<matrix sid="transform">{unit}</matrix></node><node id="body" name="body"><instance_controller url="#c">
<skeleton>#bone</skeleton><bind_material><technique_common><instance_material symbol="m" target="#paint"/>
</technique_common></bind_material></instance_controller></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
""")
    return folder / "bend.dae"
