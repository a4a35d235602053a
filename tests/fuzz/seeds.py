"""Sound files to damage."""

from __future__ import annotations

import io
import json
import struct
import tempfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.support import other_formats
from tests.support.fbx_builder import rich_scene
from tests.support.gltf_builder import GltfBuilder, png, textured_triangle
from tests.support.ogre_builder import MORPH_XML, OgreBytes, rigged

SCRIPT = """abstract material Base { set $t a.png
  technique { pass { diffuse 1 0.5 0 1
    specular 1 1 1 30
    texture_unit { texture $t
      scale 2 2
      tex_address_mode clamp } } } }
material m : Base { set $t "b c.png"
  technique { pass { emissive 0 0 2 } } }
"""
SKELETON_XML = """<skeleton><bones><bone id="0" name="a"><position x="0" y="0" z="0"/><rotation angle="0"><axis x="1"
y="0" z="0"/></rotation></bone><bone id="1" name="b"><position x="0" y="1" z="0"/><rotation angle="0.5"><axis x="0"
y="0" z="1"/></rotation></bone></bones><bonehierarchy><boneparent bone="b" parent="a"/></bonehierarchy><animations>
<animation name="walk" length="1"><tracks><track bone="b"><keyframes><keyframe time="0"><translate x="0" y="0" z="0"/>
<rotate angle="0"><axis x="0" y="1" z="0"/></rotate></keyframe><keyframe time="1"><translate x="1" y="0" z="0"/>
<rotate angle="1"><axis x="0" y="1" z="0"/></rotate></keyframe></keyframes></track></tracks></animation></animations>
</skeleton>"""


@dataclass(frozen=True, slots=True)
class Seed:
    """`files` by name; `target` is damaged, `entry` is then read: by `work` convert, check or image."""

    kind: str
    target: str
    entry: str
    files: dict[str, bytes] = field(default_factory=dict)
    work: str = "convert"

    @property
    def is_text(self) -> bool:
        data = self.files[self.target]
        return b"\0" not in data[:4096] and not data.startswith((b"\x89PNG", b"\xff\xd8"))


def all_seeds(assets: Path | None) -> list[Seed]:
    """One or more of each kind; `assets`: the folder of real files, or None."""
    return [*_gltf(), *_fbx(assets), *_ogre(), *_others(), *_images(), *_engine()]


def _gltf() -> Iterator[Seed]:
    b = _rigged_gltf()
    yield Seed("glb", "a.glb", "a.glb", {"a.glb": b.glb()})
    yield Seed("glb", "a.glb", "a.glb", {"a.glb": textured_triangle().glb()})
    with tempfile.TemporaryDirectory() as folder:
        b.write_gltf(Path(folder) / "a.gltf", "a.bin")
        files = {p.name: p.read_bytes() for p in Path(folder).iterdir()}
    yield Seed("gltf", "a.gltf", "a.gltf", files)
    yield Seed("gltf", "a.bin", "a.gltf", files)


def _rigged_gltf() -> GltfBuilder:
    """A textured triangle with a skin, a clip, a morph target and a chain of nodes."""
    b = textured_triangle()
    primitive = b.root["meshes"][0]["primitives"][0]
    primitive["attributes"]["JOINTS_0"] = b.accessor(np.zeros((3, 4)), "u1")
    primitive["attributes"]["WEIGHTS_0"] = b.accessor([[1, 0, 0, 0]] * 3)
    primitive["targets"] = [{"POSITION": b.accessor([[0, 0, 1]] * 3)}]
    b.root["nodes"] = [{"mesh": 0, "skin": 0, "children": [1]}, {"children": [2], "name": "j"}, {"name": "k"}]
    b.root["scenes"] = [{"nodes": [0]}]
    b.root["skins"] = [{"joints": [1, 2], "inverseBindMatrices": b.accessor(np.tile(np.eye(4).reshape(-1), (2, 1)))}]
    sampler = {"input": b.accessor([0.0, 1.0]), "output": b.accessor([[0, 0, 0, 1], [0, 1, 0, 0]])}
    channel = {"sampler": 0, "target": {"node": 1, "path": "rotation"}}
    b.root["animations"] = [{"samplers": [sampler], "channels": [channel]}]
    return b


def _fbx(assets: Path | None) -> Iterator[Seed]:
    yield Seed("fbx ascii", "a.fbx", "a.fbx", {"a.fbx": rich_scene().encode()})
    for path in sorted((assets or Path("/nowhere")).glob("fbx_ufbx/*.fbx")):
        if path.stat().st_size < 40_000 and "_fail_" not in path.name and path.name[0] in "bmz":
            yield Seed("fbx", "a.fbx", "a.fbx", {"a.fbx": path.read_bytes()})


def _ogre() -> Iterator[Seed]:
    for order in "<>":
        mesh, skeleton = rigged(OgreBytes(order))
        files = {"t.mesh": mesh, "t.skeleton": skeleton, "m.material": SCRIPT.encode(), "b c.png": png(2, 2)}
        yield Seed("ogre mesh", "t.mesh", "t.mesh", files)
        yield Seed("ogre skeleton", "t.skeleton", "t.mesh", files)
    yield Seed("ogre material", "m.material", "t.mesh", files)
    yield Seed("ogre xml", "t.mesh.xml", "t.mesh.xml", {"t.mesh.xml": MORPH_XML.encode()})
    linked = files | {"t.skeleton.xml": SKELETON_XML.encode()}
    del linked["t.skeleton"]
    yield Seed("ogre skeleton xml", "t.skeleton.xml", "t.mesh", linked)


def _others() -> Iterator[Seed]:
    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        for write in (other_formats.obj, other_formats.stl, other_formats.ply, other_formats.off, other_formats.dae):
            write(folder)
        files = {p.name: p.read_bytes() for p in folder.iterdir()}
    pair = {name: files[name] for name in ("box.obj", "box.mtl")} | {"skin.png": png(2, 2)}
    yield Seed("obj", "box.obj", "box.obj", pair)
    yield Seed("mtl", "box.mtl", "box.obj", pair)
    for kind, name in (("stl", "box.stl"), ("ply", "box.ply"), ("off", "box.off"), ("dae", "bend.dae")):
        yield Seed(kind, name, name, {name: files[name]})


def _images() -> Iterator[Seed]:
    from PIL import Image

    pixels = np.random.default_rng(1).integers(0, 255, (9, 7, 4), np.uint8)
    for kind, options in (("png", {}), ("jpeg", {}), ("tga", {"compression": "tga_rle"}), ("bmp", {}), ("tiff", {}),
                          ("webp", {}), ("dds", {})):  # fmt: skip
        file = io.BytesIO()
        image = Image.fromarray(pixels)
        (image.convert("RGB") if kind in ("jpeg", "bmp") else image).save(file, kind.upper(), **options)
        yield Seed(kind, f"i.{kind}", f"i.{kind}", {f"i.{kind}": file.getvalue()}, "image")
    hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 4\n" + bytes([100, 120, 90, 129]) * 16
    yield Seed("hdr", "i.hdr", "i.hdr", {"i.hdr": hdr}, "image")
    yield Seed("exr", "i.exr", "i.exr", {"i.exr": _exr()}, "image")
    psd = struct.pack(">4sH6xHIIHH", b"8BPS", 1, 3, 4, 4, 8, 3) + bytes(12) + struct.pack(">H", 0) + bytes(range(48))
    yield Seed("psd", "i.psd", "i.psd", {"i.psd": psd}, "image")
    yield Seed("ktx2", "i.ktx2", "i.ktx2", {"i.ktx2": _ktx2()}, "image")


def _exr() -> bytes:
    from engine.report.image import save_exr

    with tempfile.TemporaryDirectory() as folder:
        save_exr(Path(folder) / "i.exr", np.ones((4, 4, 3), np.float32))
        return (Path(folder) / "i.exr").read_bytes()


def _ktx2() -> bytes:
    """4x4 texels R8G8B8A8, plain and as zlib (supercompression 3)."""
    texels = zlib.compress(bytes(range(64)))
    descriptor = struct.pack("<IHHHHBBBBBBBB8B", 92, 0, 0, 2, 24 + 64, 1, 1, 1, 0, 0, 0, 0, 0, *bytes([4] + [0] * 7))
    descriptor = (descriptor + bytes(92))[:92]
    start = 80 + 24
    head = b"\xabKTX 20\xbb\r\n\x1a\n" + struct.pack("<9I", 37, 1, 4, 4, 0, 0, 1, 1, 3)
    head += struct.pack("<4I2Q", start, 92, 0, 0, 0, 0) + struct.pack("<3Q", start + 92, len(texels), 64)
    return head + descriptor + texels


def _engine() -> Iterator[Seed]:
    """What a conversion writes, and an effect."""
    from importers.convert import convert
    from importers.settings import ImportSettings

    with tempfile.TemporaryDirectory() as text:
        folder = Path(text)
        source = _rigged_gltf().write_glb(folder / "a.glb")
        for name, settings in (("out", ImportSettings()), ("small", ImportSettings(quantize=True))):
            convert(source, folder / name, settings)
        files = {p.name: p.read_bytes() for p in (folder / "out").iterdir() if p.is_file()}
        small = {p.name: p.read_bytes() for p in (folder / "small").iterdir() if p.is_file()}
    yield Seed("scene.json", "a.scene.json", "a.scene.json", files, "check")
    for name in sorted(files):
        kind = {".lmesh": "lmesh", ".lanim": "lanim", ".toml": "material.toml"}.get(Path(name).suffix, "")
        if kind:
            yield Seed(kind, name, name, files, "check")
            yield Seed(kind, name, "a.scene.json", files, "check")
    yield Seed("lmesh", "a.lmesh", "a.lmesh", small, "check")
    effect = Path(__file__).resolve().parents[2] / "shaders" / "effects" / "surface.effect.toml"
    yield Seed("effect.toml", effect.name, effect.name, {effect.name: effect.read_bytes()}, "check")


def is_json(data: bytes) -> bool:
    try:
        return isinstance(json.loads(data), dict | list)
    except (ValueError, RecursionError):
        return False
