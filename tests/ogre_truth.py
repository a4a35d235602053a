"""Skinned vertices straight from Ogre's XML, or its binary files, in float64, with nothing of the engine's: the tests'
truth. At keys' times only: between them Ogre and glTF do not mean the same."""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np


@dataclass(slots=True)
class Bone:
    name: str
    place: np.ndarray
    turn: np.ndarray
    parent: int = -1


@dataclass(slots=True)
class OgreTruth:
    """`points` f8[n,3], per vertex lists of (bone, weight); clips: name -> bone -> keys (time, move, turn, scale)."""

    points: np.ndarray
    influences: list[dict[int, float]]
    bones: dict[int, Bone]
    clips: dict[str, dict[int, list[tuple[float, np.ndarray, np.ndarray, np.ndarray]]]] = field(default_factory=dict)

    def times(self, clip: str) -> list[float]:
        return sorted({key[0] for keys in self.clips[clip].values() for key in keys})

    def shared_times(self, clip: str) -> list[float]:
        """Times at which every track that moves has a key: there nothing is interpolated."""
        sets = [{round(k[0], 5) for k in keys} for keys in self.clips[clip].values() if len(keys) > 1]
        return sorted(set.intersection(*sets)) if sets else [0.0]

    def skinned(self, clip: str, time: float) -> np.ndarray:
        """f8[n,3] at a time that all tracks have a key at."""
        rest = self._world({})
        posed = self._world({bone: self._key(keys, time) for bone, keys in self.clips[clip].items()})
        matrices = {b: posed[b] @ np.linalg.inv(rest[b]) for b in self.bones}
        out = np.zeros_like(self.points)
        for i, (point, own) in enumerate(zip(self.points, self.influences, strict=True)):
            total = sum(own.values())
            for bone, weight in own.items():
                out[i] += weight / total * (matrices[bone] @ np.append(point, 1.0))[:3]
        return out

    def _key(self, keys: list[tuple[float, np.ndarray, np.ndarray, np.ndarray]], time: float) -> tuple[np.ndarray, ...]:
        if len(keys) == 1:
            return keys[0][1:]
        found = [k for k in keys if abs(k[0] - time) < 2e-5]
        return found[-1][1:]  # of two at one time the last holds from there on

    def _world(self, keys: dict[int, tuple[np.ndarray, ...]]) -> dict[int, np.ndarray]:
        world: dict[int, np.ndarray] = {}

        def place(bone: int) -> np.ndarray:
            if bone not in world:
                b = self.bones[bone]
                move, turn, scale = keys.get(bone, (np.zeros(3), np.array([0.0, 0, 0, 1]), np.ones(3)))
                local = np.eye(4)
                local[:3, :3] = _matrix(b.turn) @ _matrix(turn) @ np.diag(scale)
                local[:3, 3] = b.place + move
                world[bone] = (place(b.parent) @ local) if b.parent >= 0 else local
            return world[bone]

        for bone in self.bones:
            place(bone)
        return world


def read_xml(mesh: Path) -> OgreTruth:
    """`X.mesh.xml` with `X.skeleton.xml` beside it."""
    root = ElementTree.parse(mesh).getroot()
    points: list[list[float]] = []
    influences: list[dict[int, float]] = []
    holders = [root.find("sharedgeometry")] if root.find("sharedgeometry") is not None else []
    for holder in [*holders, *root.findall("./submeshes/submesh")]:
        first = len(points)
        geometry = holder if holder.tag == "sharedgeometry" else holder.find("geometry")
        assigned = root.find("boneassignments") if holder.tag == "sharedgeometry" else holder.find("boneassignments")
        if geometry is None:
            continue
        for position in geometry.iter("position"):
            points.append([float(position.get(axis)) for axis in "xyz"])
            influences.append({})
        for a in assigned if assigned is not None else ():
            own = influences[first + int(a.get("vertexindex"))]
            own[int(a.get("boneindex"))] = own.get(int(a.get("boneindex")), 0.0) + float(a.get("weight"))
    truth = OgreTruth(np.array(points), influences, {})
    _xml_skeleton(ElementTree.parse(mesh.with_name(mesh.name.replace(".mesh.", ".skeleton."))).getroot(), truth)
    return truth


def _xml_skeleton(root: ElementTree.Element, truth: OgreTruth) -> None:
    def vector(element: ElementTree.Element | None, default: float = 0.0) -> np.ndarray:
        return np.full(3, default) if element is None else np.array([float(element.get(a)) for a in "xyz"])

    def turn(element: ElementTree.Element | None) -> np.ndarray:
        if element is None:
            return np.array([0.0, 0.0, 0.0, 1.0])
        half = 0.5 * float(element.get("angle"))
        axis = vector(element.find("axis"))
        length = np.linalg.norm(axis)
        return np.append(axis / length * np.sin(half) if length else np.zeros(3), np.cos(half))

    number = {}
    for bone in root.find("bones"):
        number[bone.get("name")] = int(bone.get("id"))
        truth.bones[int(bone.get("id"))] = Bone(
            bone.get("name"), vector(bone.find("position")), turn(bone.find("rotation"))
        )
    for link in root.find("bonehierarchy"):
        truth.bones[number[link.get("bone")]].parent = number[link.get("parent")]
    for animation in root.iter("animation"):
        clip = truth.clips.setdefault(animation.get("name"), {})
        for track in animation.iter("track"):
            clip[number[track.get("bone")]] = [
                (
                    float(key.get("time")), vector(key.find("translate")), turn(key.find("rotate")),
                    vector(key.find("scale"), 1.0),
                )
                for key in track.iter("keyframe")
            ]  # fmt: skip


def read_binary(mesh: Path) -> OgreTruth:
    """`X.mesh` with `X.skeleton` beside it: only the chunks that skinning needs (Ogre 1.x serializers)."""
    data = mesh.read_bytes()
    start = data.index(b"\n") + 1
    points: list[np.ndarray] = []
    influences: list[dict[int, float]] = []
    state = {"count": 0, "position": None, "source": 0, "first": 0}

    def walk(at: int, end: int) -> None:
        while at + 6 <= end:
            kind, size = struct.unpack_from("<HI", data, at)
            inner, after = at + 6, at + size
            if kind == 0x3000:  # mesh
                walk(inner + 1, after)
            elif kind == 0x4000:  # submesh: material name, shared flag, indices
                line = data.index(b"\n", inner) + 1
                shared, count, wide = struct.unpack_from("<?I?", data, line)
                walk(line + 6 + count * (4 if wide else 2), after)
                del shared
            elif kind == 0x5000:  # geometry
                state.update(count=struct.unpack_from("<I", data, inner)[0], first=len(points))
                walk(inner + 4, after)
            elif kind in (0x5100, 0x5200):
                if kind == 0x5200:
                    state["bind"], state["stride"] = struct.unpack_from("<HH", data, inner)
                    walk(inner + 4, after)
                else:
                    walk(inner, after)
            elif kind == 0x5110:  # element: source, type, semantic, offset, index
                source, _, semantic, offset, _ = struct.unpack_from("<HHHHH", data, inner)
                if semantic == 1:
                    state.update(source=source, position=offset)
            elif kind == 0x5210 and state["bind"] == state["source"]:
                for i in range(state["count"]):
                    points.append(
                        np.array(struct.unpack_from("<3f", data, inner + i * state["stride"] + state["position"]))
                    )
                    influences.append({})
            elif kind in (0x4100, 0x7000):  # bone assignment
                vertex, bone, weight = struct.unpack_from("<IHf", data, inner)
                own = influences[state["first"] + vertex]
                own[bone] = own.get(bone, 0.0) + weight
            at = after

    walk(start, len(data))
    truth = OgreTruth(np.array(points), influences, {})
    _binary_skeleton(mesh.with_suffix(".skeleton").read_bytes(), truth)
    return truth


def _binary_skeleton(data: bytes, truth: OgreTruth) -> None:
    at = data.index(b"\n") + 1
    clip: dict[int, list[tuple[float, np.ndarray, np.ndarray, np.ndarray]]] = {}
    track: list[tuple[float, np.ndarray, np.ndarray, np.ndarray]] = []
    while at + 6 <= len(data):
        kind, size = struct.unpack_from("<HI", data, at)
        inner = at + 6
        if kind == 0x2000:
            line = data.index(b"\n", inner)
            name = data[inner:line].decode()
            number = struct.unpack_from("<H", data, line + 1)[0]
            values = struct.unpack_from("<7f", data, line + 3)
            truth.bones[number] = Bone(name, np.array(values[:3]), np.array(values[3:]))
            at = line + 31  # the chunk's own size does not count the name in old files
            continue
        if kind == 0x3000:
            child, parent = struct.unpack_from("<HH", data, inner)
            truth.bones[child].parent = parent
        elif kind == 0x4000:
            line = data.index(b"\n", inner)
            clip = truth.clips.setdefault(data[inner:line].decode(), {})
            at = line + 5
            continue
        elif kind == 0x4100:
            track = clip.setdefault(struct.unpack_from("<H", data, inner)[0], [])
            at = inner + 2
            continue
        elif kind == 0x4110:
            many = (size - 6) // 4
            values = struct.unpack_from(f"<{many}f", data, inner)
            scale = np.array(values[8:11]) if many >= 11 else np.ones(3)
            track.append((values[0], np.array(values[5:8]), np.array(values[1:5]), scale))
        at += size


def _matrix(q: np.ndarray) -> np.ndarray:
    x, y, z, w = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
