"""Skinned vertices straight from a .glb or .gltf file, in float64, with nothing of the engine's: the tests' truth."""

from __future__ import annotations

import base64
import json
import struct
from pathlib import Path

import numpy as np

TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Gltf:
    def __init__(self, path: Path) -> None:
        data = path.read_bytes()
        self.buffers: list[bytes] = []
        binary = b""
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            self.json = json.loads(data[20 : 20 + length])
            if len(data) > 28 + length:
                size = struct.unpack_from("<I", data, 20 + length)[0]
                binary = data[28 + length : 28 + length + size]
        else:
            self.json = json.loads(data)
        for buffer in self.json["buffers"]:
            uri = buffer.get("uri")
            if uri is None:
                self.buffers.append(binary)
            elif uri.startswith("data:"):
                self.buffers.append(base64.b64decode(uri.split(",", 1)[1]))
            else:
                self.buffers.append((path.parent / uri).read_bytes())
        self.parent = {c: i for i, n in enumerate(self.json["nodes"]) for c in n.get("children", [])}

    def accessor(self, index: int) -> np.ndarray:
        """Float64 (normalised integers as fractions), [count, width]."""
        a = self.json["accessors"][index]
        view = self.json["bufferViews"][a["bufferView"]]
        dtype, width = np.dtype(TYPES[a["componentType"]]), WIDTHS[a["type"]]
        start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
        stride = view.get("byteStride", dtype.itemsize * width)
        raw = np.frombuffer(self.buffers[view["buffer"]], np.uint8)[start:]
        rows = np.lib.stride_tricks.as_strided(raw, (a["count"], dtype.itemsize * width), (stride, 1))
        values = np.ascontiguousarray(rows).view(dtype).astype(np.float64)
        return values / np.iinfo(dtype).max if a.get("normalized") else values

    def locals_at(self, time: float, animation: int = 0) -> list[np.ndarray]:
        """Every node's local matrix at `time` of an animation."""
        pose = [
            {
                "translation": np.array(n.get("translation", [0, 0, 0]), np.float64),
                "rotation": np.array(n.get("rotation", [0, 0, 0, 1]), np.float64),
                "scale": np.array(n.get("scale", [1, 1, 1]), np.float64),
            }
            for n in self.json["nodes"]
        ]
        clip = self.json["animations"][animation]
        moved = set()
        for channel in clip["channels"]:
            path, node = channel["target"]["path"], channel["target"]["node"]
            if path in ("translation", "rotation", "scale"):
                pose[node][path] = self._value(clip["samplers"][channel["sampler"]], path, time)
                moved.add(node)
        result = []
        for i, (node, p) in enumerate(zip(self.json["nodes"], pose, strict=True)):
            if "matrix" in node and i not in moved:
                result.append(np.array(node["matrix"], np.float64).reshape(4, 4).T)
                continue
            x, y, z, w = p["rotation"] / np.linalg.norm(p["rotation"])
            m = np.eye(4)
            m[:3, :3] = [
                [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
            ]
            m[:3, :3] *= p["scale"]
            m[:3, 3] = p["translation"]
            result.append(m)
        return result

    def _value(self, sampler: dict, path: str, time: float) -> np.ndarray:
        times, values = self.accessor(sampler["input"])[:, 0], self.accessor(sampler["output"])
        kind = sampler.get("interpolation", "LINEAR")
        assert kind in ("LINEAR", "STEP"), kind
        if time <= times[0]:
            return values[0]
        if time >= times[-1]:
            return values[-1]
        i = max(k for k in range(len(times)) if times[k] <= time)
        if kind == "STEP":
            return values[i]
        u = (time - times[i]) / (times[i + 1] - times[i])
        a, b = values[i], values[i + 1]
        if path != "rotation":
            return a * (1 - u) + b * u
        a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
        if a @ b < 0:
            b = -b
        # the axis-angle form: turn a towards b by u of the angle between, in the plane of both
        across = b - (a @ b) * a
        sine = np.linalg.norm(across)
        if sine < 1e-12:
            return a
        angle = u * np.arctan2(sine, a @ b)
        return a * np.cos(angle) + across / sine * np.sin(angle)

    def skinned(self, time: float) -> tuple[np.ndarray, np.ndarray]:
        """(bind positions, posed positions in the world), f8[n,3] of all skinned primitives one after another."""
        local = self.locals_at(time)
        world: dict[int, np.ndarray] = {}

        def place(node: int) -> np.ndarray:
            if node not in world:
                above = place(self.parent[node]) if node in self.parent else np.eye(4)
                world[node] = above @ local[node]
            return world[node]

        bind, posed = [], []
        for node in self.json["nodes"]:
            if "skin" not in node or "mesh" not in node:
                continue
            skin = self.json["skins"][node["skin"]]
            inverse = self.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
            matrices = np.stack([place(j) @ m for j, m in zip(skin["joints"], inverse, strict=True)])
            for primitive in self.json["meshes"][node["mesh"]]["primitives"]:
                attributes = primitive["attributes"]
                position = self.accessor(attributes["POSITION"])
                joints = self.accessor(attributes["JOINTS_0"]).astype(int)
                weights = self.accessor(attributes["WEIGHTS_0"])
                weights = weights / weights.sum(axis=1, keepdims=True)
                blend = np.einsum("nk,nkij->nij", weights, matrices[joints])
                bind.append(position)
                posed.append(np.einsum("nij,nj->ni", blend[:, :3, :3], position) + blend[:, :3, 3])
        return np.concatenate(bind), np.concatenate(posed)
