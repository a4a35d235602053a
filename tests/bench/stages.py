"""The bench scenes: N cubes on a lattice, 8 materials, a node each; by the engine, and by hand in raw moderngl."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.app.framing import frame_bounds
from engine.app.runtime import Runtime
from engine.assets.material import MaterialAsset
from engine.assets.primitives import cube
from engine.assets.scene import EnvironmentAsset, SceneAsset
from engine.gpu import open_device
from engine.render.settings import RenderSettings
from engine.render.view import View

SIZE = (320, 180)
COLORS = [
    (0.9, 0.2, 0.2), (0.2, 0.9, 0.2), (0.2, 0.3, 0.9), (0.9, 0.8, 0.2),
    (0.8, 0.2, 0.8), (0.2, 0.8, 0.8), (0.9, 0.5, 0.1), (0.8, 0.8, 0.8),
]  # fmt: skip


def lattice(count: int) -> NDArray[np.float64]:
    """`count` points, 2 m apart, in a cube about the origin: f8[count,3]."""
    side = math.ceil(round(count ** (1 / 3), 6))
    i = np.arange(count)
    cells = np.stack([i % side, i // side % side, i // side**2], axis=1)
    return (cells - (side - 1) / 2) * 2.0


def motion(points: NDArray[np.float64], phases: int = 4) -> list[NDArray[np.float64]]:
    """Positions that differ between any two successive frames."""
    bob = [0.4 * np.sin(np.arange(len(points)) * 0.7 + p * 2 * np.pi / phases) for p in range(phases)]
    return [points + np.stack([np.zeros_like(b), b, np.zeros_like(b)], axis=1) for b in bob]


class EngineStage:
    """The engine's own way: nodes, instances, materials, a sun. `backend`: gl or null. The floor casts no shadows."""

    def __init__(self, backend: str, count: int, *, shadows: bool = False) -> None:
        self.device: Any = open_device(backend)
        if backend == "null":
            self.device.record = False
        self.runtime = Runtime(self.device, profile=False)
        look = EnvironmentAsset(kind="none", background="color", sun_illuminance=3.0)
        asset = SceneAsset("bench", environment=look)
        asset.look.tone_map = "none"
        self.runtime.load(asset, Path())
        residency = self.runtime.residency
        mesh = residency.add_meshes([cube()])[0]
        materials = [
            residency.add_material(
                MaterialAsset(f"m{i}", params={"base_color": (*c, 1.0), "metallic": 0.0, "roughness": 0.5}), Path()
            )
            for i, c in enumerate(COLORS)
        ]
        points = lattice(count)
        self.phases = motion(points)
        self.rows = self.runtime.scene.nodes.add_many(
            [f"cube{i}" for i in range(count)], np.full(count, -1), points,
            np.tile((0.0, 0.0, 0.0, 1.0), (count, 1)), np.ones((count, 3)),
        )  # fmt: skip
        sphere = residency.meshes[mesh].bounds[0]
        self.runtime.scene.instances.add_many(
            self.rows, np.full(count, mesh), np.zeros(count, int), np.array(materials)[np.arange(count) % 8],
            np.tile(sphere[:3], (count, 1)), np.full(count, sphere[3], np.float32),
        )  # fmt: skip
        self.runtime.update()
        camera = frame_bounds(*self.runtime.bounds(), SIZE[0] / SIZE[1])
        self.view = View(camera, *SIZE, RenderSettings(samples=1, shadows=shadows))
        self._tick = 0
        self.counters: dict[str, float] = {}

    def frame(self, *, move: bool, read: bool = True) -> NDArray[Any] | None:
        """One frame: move every node by the table API, update, draw, read the picture back."""
        if move:
            self._tick += 1
            self.runtime.scene.nodes.set_translation(self.rows, self.phases[self._tick % 4])
        frame = self.runtime.render(self.view)
        self.counters = frame.stats.counters
        return frame.color.read() if read else None

    def close(self) -> None:
        self.runtime.close()
        self.device.release()


VERTEX = """#version 430
in vec3 position; in vec3 normal; in uint id;
layout(std430, binding = 0) readonly buffer Models { mat4 model[]; };
layout(std430, binding = 1) readonly buffer Materials { uint material[]; };
uniform mat4 clip_from_world; uniform vec3 colors[8];
out vec3 n; out vec3 c; out vec3 w;
void main() {
    vec4 p = model[id] * vec4(position, 1.0);
    w = p.xyz; n = mat3(model[id]) * normal; c = colors[material[id]];
    gl_Position = clip_from_world * p;
}"""
FRAGMENT = """#version 430
in vec3 n; in vec3 c; in vec3 w; out vec4 color; uniform vec3 eye;
void main() {
    vec3 N = normalize(n), L = normalize(vec3(10, 20, 15)), H = normalize(L + normalize(eye - w));
    color = vec4(c * (0.15 + 0.8 * max(dot(N, L), 0.0)) + 0.1 * pow(max(dot(N, H), 0.0), 32.0), 1.0);
}"""


class FloorStage:
    """The floor: the same cubes by hand in raw moderngl, a matrix and a material index each, Blinn-Phong, 8-bit target,
    one multi-draw-indirect call. What the engine adds to it is the engine's own cost (and its better shading)."""

    def __init__(self, count: int) -> None:
        import moderngl

        self.context = moderngl.create_context(standalone=True, require=430, backend="egl")
        context = self.context
        self.target = context.framebuffer([context.renderbuffer(SIZE, 4)], context.depth_renderbuffer(SIZE))
        program = context.program(VERTEX, FRAGMENT)
        mesh = cube()
        normal = np.asarray(mesh.streams["normal"])[:, :3].astype(np.float32) / 32767
        vertices = np.hstack([np.asarray(mesh.streams["position"]), normal]).astype("f4")
        self.vao = context.vertex_array(
            program,
            [
                (context.buffer(vertices.tobytes()), "3f 3f", "position", "normal"),
                (context.buffer(np.arange(count, dtype="u4").tobytes()), "1u/i", "id"),
            ],
            context.buffer(mesh.indices.tobytes()),
        )
        points = lattice(count)
        self.phases = [p.astype("f4") for p in motion(points)]
        self.matrices = np.tile(np.eye(4, dtype="f4"), (count, 1, 1))
        self.matrices[:, 3, :3] = points
        self.models = context.buffer(self.matrices.tobytes(), dynamic=True)
        self.materials = context.buffer((np.arange(count) % 8).astype("u4").tobytes())
        commands = np.zeros((count, 5), "u4")
        commands[:, 0], commands[:, 1], commands[:, 4] = 36, 1, np.arange(count)
        self.commands = context.buffer(commands.tobytes())
        camera = frame_bounds(points.min(0) - 0.5, points.max(0) + 0.5, SIZE[0] / SIZE[1])
        clip = camera.clip_from_world(SIZE[0] / SIZE[1])
        clip[2] = clip[3] - 2.0 * clip[2]  # reversed depth [1,0] to OpenGL's [-1,1]
        program["clip_from_world"].write(np.ascontiguousarray(clip.T, "f4"))
        program["eye"].value = tuple(camera.position)
        program["colors"].value = COLORS
        self.count = count
        self.pixels = bytearray(SIZE[0] * SIZE[1] * 4)
        self._tick = 0

    def frame(self, *, move: bool) -> bytearray:
        import moderngl

        with self.context:
            self.models.bind_to_storage_buffer(0)
            self.materials.bind_to_storage_buffer(1)
            if move:
                self._tick += 1
                self.matrices[:, 3, :3] = self.phases[self._tick % 4]
                self.models.write(self.matrices)
            self.target.use()
            self.context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
            self.target.clear(0.1, 0.1, 0.12, 1.0)
            self.vao.render_indirect(self.commands, count=self.count)
            self.target.read_into(self.pixels, components=4)
        return self.pixels

    def close(self) -> None:
        self.context.release()
