"""Shadows of the sun: how the view's depth is split, what each cascade sees, how far a lookup is moved. CPU only.

splits.py    practical split scheme           light_space.py  axes with the sun's direction as z
slices.py    bounding sphere of a slice       fit.py          cascades around what the view shows, on a world grid
sun.py       SunShadows: this frame's cascades, who casts into each, keys of what is drawn
bias.py      how far a receiver is lifted     quality.py      what of the settings changes the frame's structure

camera, sun, bounding spheres ─► fit ─► cascades ─► rows of the view block ─► shaders/lib/shadows.glsl
                                    └─► caster masks, keys ─► passes/shadow_cascades.py ─► d32f array

Depth in the maps is reversed as everywhere: 1 towards the sun, 0 away from it, cleared to 0 (nothing casts); a point is
lit where its depth is at least the map's.

Only direct light of the first sun is shadowed: the environment's if it has one, else the first directional light.
Solid lit surfaces cast, blended and unlit ones do not; all lit surfaces, blended ones too, show shadows.
"""
