"""The poles: a field of thin poles seen from among them, so that almost every tile of a picture holds near and far.

What culling lights by a tile's nearest and farthest depth is worst at: the box between them is mostly air.
"""

from __future__ import annotations

import numpy as np

from engine.assets.clip import ClipAsset
from engine.assets.samples.sample import DEFAULT_LIGHTS, SampleScene
from engine.assets.samples.shapes import Patches, box
from engine.assets.samples.swarm import Swarm, add_swarm, hues, phases
from engine.assets.scene import CameraAsset, EnvironmentAsset, LightAsset, LookAsset, NodeAsset, SceneAsset

#: m: half the field's width, and the highest pole
FIELD, HIGH = 20.0, 6.0
POLES = 400


def build(lights: int = DEFAULT_LIGHTS, seed: int = 1, reach: float = 1.0) -> SampleScene:
    """Return the field with that many point lights; `reach` scales how far each shines (3 m)."""
    rng = np.random.default_rng(seed)
    surroundings = EnvironmentAsset(
        "uniform", color=(0.012, 0.016, 0.028), background="environment", sun_illuminance=0.0, background_blur=0.0
    )
    sample = SampleScene(SceneAsset("poles", environment=surroundings, look=LookAsset(tone_map="neutral")))
    ground = sample.material("ground", base_color=(0.30, 0.30, 0.28, 1.0), roughness=0.6)
    sample.place(
        "ground", sample.mesh(box("ground", (-FIELD - 2, -0.2, -FIELD - 2), (FIELD + 2, 0.0, FIELD + 2))), ground
    )
    _poles(sample, rng)
    _camera(sample.scene)
    clip = ClipAsset("drift")
    parent = len(sample.scene.nodes)
    sample.scene.nodes.append(NodeAsset("lights"))
    still = rng.uniform((-FIELD, 0.3, -FIELD), (FIELD, HIGH, FIELD), (lights, 3))
    turn = phases() + rng.uniform(0.0, 2.0 * np.pi, lights)
    path = still + 0.5 * np.stack([np.cos(turn), 0.3 * np.sin(2.0 * turn), np.sin(turn)], axis=-1)
    like = LightAsset("point", intensity=3.0 * DEFAULT_LIGHTS / max(lights, 1), range=3.0 * reach)
    add_swarm(sample.scene, clip, Swarm("light", like, path[0], hues(rng, lights, 0.6), path), parent)
    if clip.channels:
        sample.clips.append(clip)
        sample.scene.clips.append("poles.drift.lanim")
    return sample


def _poles(sample: SampleScene, rng: np.random.Generator) -> None:
    paint = [
        sample.material("pole white", base_color=(0.75, 0.74, 0.70, 1.0), roughness=0.5),
        sample.material("pole red", base_color=(0.55, 0.08, 0.06, 1.0), roughness=0.35),
    ]
    shaft = Patches()
    shaft.turned([[(0.0, 1.0), (1.0, 1.0)], [(1.0, 1.0), (1.0, 0.0)]], 12)
    mesh = sample.mesh(shaft.mesh("pole"))
    side = round(POLES**0.5)
    cell = 2.0 * FIELD / side
    spread = rng.uniform(-0.35, 0.35, (POLES, 2)) * cell
    radius, height = rng.uniform(0.03, 0.06, POLES), rng.uniform(3.0, HIGH, POLES)
    for k in range(POLES):
        x = -FIELD + (k % side + 0.5) * cell + spread[k, 0]
        z = -FIELD + (k // side + 0.5) * cell + spread[k, 1]
        size = (float(radius[k]), float(height[k]), float(radius[k]))
        sample.place(f"pole {k + 1}", mesh, paint[k % 2], (float(x), 0.0, float(z)), scale=size)


def _camera(scene: SceneAsset) -> None:
    node = NodeAsset("camera", -1, (1.0, 1.7, FIELD + 1.0))
    node.camera = CameraAsset(yfov=0.95, znear=0.05)
    scene.active_camera = len(scene.nodes)
    scene.nodes.append(node)
