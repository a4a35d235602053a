"""What skinning in the vertex stage costs a frame: skinned figures against the same ones rigid, alternating in one run.

The difference is all that doing it elsewhere (once for all passes) could save, less what that itself would cost. Small
pictures, so that vertices and not pixels are what is paid for; everything moves, so shadow maps are made anew.
"""

from __future__ import annotations

import copy
import tempfile
import time
from pathlib import Path

import numpy as np

from engine.app.runtime import Runtime
from engine.assets.samples.sample import SampleScene, make_sample, write_sample
from engine.gpu import open_device
from engine.render.settings import RenderSettings
from engine.render.view import View
from engine.report.summary import summarise
from tests.bench.harness import Context, Row

SIZE = (96, 64)
#: what makes the vertices be transformed how often
PASSES = {
    "picture": RenderSettings(samples=1, shadows=False, ambient_occlusion="off"),
    "+ depth pass": RenderSettings(samples=1, shadows=False, ambient_occlusion="gtao"),
    "+ depth pass, 4 cascades": RenderSettings(samples=1, shadows=True, ambient_occlusion="gtao"),
}
VARIANTS = ("rigid", "linear, 4", "dual quaternions, 4", "linear, 8")


def run(ctx: Context) -> list[Row]:
    rows: list[Row] = []
    for count in (1, 16) if ctx.quick else (1, 16, 100):
        rows += crowd(count, 5 if ctx.quick else 15)
    return rows


def crowd(count: int, repeats: int) -> list[Row]:
    device = open_device("gl")
    stages = {}
    with tempfile.TemporaryDirectory() as folder:
        for variant in VARIANTS:
            path = Path(folder) / variant.replace(",", "")
            path.mkdir()
            stages[variant] = Runtime(device, profile=False)
            stages[variant].open(write_sample(figures(count, variant), path))
            if variant.startswith("dual"):
                for skin in range(len(stages[variant].scene.skins)):
                    stages[variant].scene.skins.set_method(skin, "dual_quaternion")
    rows = []
    for passes, settings in PASSES.items():
        times: dict[str, list[float]] = {name: [] for name in VARIANTS}
        for i in range(repeats + 3):
            for name, runtime in stages.items():
                spent = frame(runtime, settings, name == "rigid")
                if i >= 3:
                    times[name].append(spent)
        least = {name: min(spent) for name, spent in times.items()}
        for name in VARIANTS:
            more = least[name] - least["rigid"]
            note = "" if name == "rigid" else f"{more:+.2f} ms, {more / least['rigid']:+.0%} at best"
            rows.append(Row(f"{count} x 3,757 vertices", f"{passes}: {name}", summarise(times[name]), note=note))
    for runtime in stages.values():
        runtime.close()
    return rows


def figures(count: int, variant: str) -> SampleScene:
    """The walker sample with `count` bodies, each on joints of its own."""
    sample = make_sample("walker")
    nodes = sample.scene.nodes
    body = next(i for i, node in enumerate(nodes) if node.joints)
    one = [copy.deepcopy(node) for node in nodes[: body + 1]]
    if variant == "linear, 8":
        streams = sample.meshes[0].streams
        streams["joints1"], streams["weights1"] = np.zeros_like(streams["joints"]), np.zeros_like(streams["weights"])
    for i in range(1, count):
        first = len(nodes)
        for node in copy.deepcopy(one):
            node.parent = node.parent + first if node.parent >= 0 else -1
            node.joints = [j + first for j in node.joints]
            nodes.append(node)
        nodes[first].translation = (0.9 * (i % 10), 0.0, -0.9 * (i // 10))
    sample.scene.animation = sample.scene.drive = ""
    if variant == "rigid":
        sample.meshes[0].skeleton = None
        for name in ("joints", "weights"):
            del sample.meshes[0].streams[name]
        for node in nodes:
            node.joints = []
    return sample


def frame(runtime: Runtime, settings: RenderSettings, rigid: bool) -> float:
    """ms of processor time for one picture after everything has moved."""
    scene = runtime.scene
    rows = np.unique(scene.instances.node) if rigid else scene.skins.joint[scene.skins.first]
    scene.nodes.set_translation(rows, scene.nodes.translation[rows] + 1e-9)
    scene.update()
    camera = runtime.framing_camera(SIZE[0] / SIZE[1])
    start = time.process_time()
    runtime.render(View(camera, *SIZE, settings)).color.read()
    return (time.process_time() - start) * 1e3
