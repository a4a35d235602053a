"""Which passes make a frame, by path. All paths share the surface shader, the light table and one sum of lights.

forward.py      every surface is shaded as it is drawn, by all lights of the scene: the truth
forward_plus.py depth first, light lists per tile, then as forward with the tile's list; MSAA
deferred.py     surfaces write a G-buffer; light volumes, or one compute pass over tiles, add the local lights
choice.py       which path a frame takes, and why: asked for, or the cheapest by a cost model

    shadows ─► depth ─► lists ─► opaque (lists) ─────────────────────► sky ─► transparent (lists) ─► lens
    shadows ─► opaque + G-buffer ─► lists ─► tiled shading / volumes ─► sky ─► transparent (lists) ─► lens
    lens: depth of field ─► TAA ─► auto exposure meters ─► bloom ─► resolve (linear output) ─► tone map ─► FXAA or SMAA;
          each only where it is wanted (lens.py)
motion vectors are made from depth: after the depth that comes first, or after everything solid (passes/motion.py)
Where ambient occlusion is wanted, or `depth_first` says so, depth comes first in every path, and what it hides is known
when surfaces are shaded.
So it is with light between surfaces and reflections (engine/render/gi): depth ─► layers ─► radiosity ─► gather.
Surfaces of effects without a `gbuffer` technique (layers, other microfacet terms, toon) are drawn behind the lighting
in the deferred paths, by all lights, unpacked in every path. Before `transparent` comes a copy of the picture where
something shows what is behind it (passes/scene_color.py).
Where a scene has no local light every path is the forward one, to the bit.
"""
