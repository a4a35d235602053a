"""Light from surface to surface in screen space, on a deep G-buffer: what the camera sees and what lies behind it.

May import what engine.render may. The passes are in engine/render/passes, named beside what they do:

    depth first ─► deep_gbuffer   layer 0: what is seen; layer 1: the nearest surface behind it by `separation`
                ─► radiosity      what both layers send out: lamps, suns (with shadows), emission; smaller sizes of it
                ─► bounces        what they reflect of light gathered at coarse texels, again and again
                ─► indirect       gathered at each pixel, mixed with the frames before, filtered
                ─► reflections    the mirrored view goes through both layers, over large pieces where nothing is
                ─► opaque surfaces read both (shaders/lib/indirect.glsl)

choice.py      which of it a view has, and how far it looks
block.py       the uniform block of these passes
gather.py      the gather and the textures that it reads
layers.py      pipelines that draw the layers
state.py       what is kept between frames: the camera before, the scene's size

After Mara, McGuire, Nowrouzezahrai, Luebke 2016, "Deep G-Buffers for Stable Global Illumination Approximation" (two
layers with a minimum separation; radiosity; confidence); the gather in slices follows Therrien, Levesque, Gilet 2023,
"Screen Space Indirect Lighting with Visibility Bitmask", with arcs weighted as in Jimenez et al. 2016.
"""
