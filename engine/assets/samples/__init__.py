"""Sample scenes made by code: nothing is read, the same arguments give the same bytes. May import assets and math.

    SAMPLES[name](lights=…, seed=…) ─> SampleScene (scene, meshes, materials, clips: all in memory)
                                          ├─ write_sample(sample, folder)         files that any door opens
                                          └─ engine.resources.samples.add_sample  straight into a scene and a residency

shapes.py   walls, columns, arches as MeshAssets        swarm.py    many lights with their colours and their motion
walker.py   a figure that idles, walks, runs and waves  sample.py   SampleScene, make_sample, write_sample
atrium.py   a two-storey hall, 1,024 moving lights      poles.py    a field of thin poles: depth steps everywhere
"""

from __future__ import annotations

#: name -> (module, what it is, shown by `lucarna new --sample`)
SAMPLES: dict[str, tuple[str, str]] = {
    "atrium": ("engine.assets.samples.atrium", "a two-storey hall with columns and arches, 1,024 moving lights"),
    "poles": ("engine.assets.samples.poles", "a field of 400 thin poles, 1,024 lights between them"),
}
#: the same of those without a swarm of lights
CHARACTERS: dict[str, tuple[str, str]] = {
    "walker": ("engine.assets.samples.walker", "a figure that idles, walks, runs and waves, and how these blend"),
}
