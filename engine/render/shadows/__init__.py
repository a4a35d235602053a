"""Shadow maps of the sun and of lamps: what each sees, who casts into it, how far a lookup is moved.

splits.py    practical split scheme           light_space.py  axes with the sun's direction as z
slices.py    bounding sphere of a slice       fit.py          cascades around what the view shows, on a world grid
sun.py       SunShadows: this frame's cascades, who casts into each, keys of what is drawn
bias.py      how far a receiver is lifted     quality.py      what of the settings changes the frame's structure
casters.py   sound bounds, what moved when    moments.py      maps that can be blurred: bounds, limits, weights
atlas.py     tiles by importance              faces.py        what a tile sees: along a spot, or a side of a cube
floor.py     ShadowFloor: a floor that nothing but shadows is seen of
local.py     LocalShadows: tiles of local lights, who casts into each, keys, the buffer of the lookups
tint_request.py   what a batch asks of the effect library where blended surfaces tint the light of the sun or of lamps

camera, sun, bounding spheres ─► fit ─► cascades ─► rows of the view block ─► shaders/lib/shadows.glsl
                                    └─► caster masks, keys ─► passes/shadow_cascades.py ─► d32f array
                                        ─► passes/shadow_moments.py, for filters that blur ─► moments, mips
                                        ─► passes/shadow_tints.py, where shadows are translucent ─► colours, depth of
                                           the nearest ─► shaders/lib/shadow_tint.glsl

lights that cast ─► atlas, faces ─► tiles ─► rows of a buffer ─► shaders/lib/local_shadows.glsl, soft_lamps.glsl
                                         └─► caster masks, keys ─► passes/local_shadows.py ─► d32f atlas
                                             ─► passes/local_moments.py, for filters that blur ─► moments
                                             ─► passes/local_tints.py ─► colours ─► shaders/lib/local_tint.glsl

Depth in the maps is reversed as everywhere: 1 towards the sun, 0 away from it, cleared to 0 (nothing casts); a point is
lit where its depth is at least the map's.

Only direct light is shadowed: of the first sun (the environment's if it has one, else the first directional light) and
of the local lights that cast; other suns shine through things. A local light with a size (an area light, a lamp with a
radius) throws shadows as soft as geometry makes them.
Solid lit surfaces cast, blended and unlit ones do not; all lit surfaces, blended ones too, show shadows.

With `translucent_shadows` blended lit surfaces are filters for light that casts shadows: each leaves mix(white, its
base colour, its alpha) of the light that meets it, a transmissive one its base colour times its transmission (McGuire,
Mara 2017); filters in a row are a product. As often as a camera in the light would see the surface blended: a closed
body once, with both faces twice. A white pane leaves all light, whatever its alpha. Only the depth of the pane nearest
to the light is known: what is between two of them has the tint of both. pcss and the blurred maps look tints up in a
disc of the filter's radius; a lamp with a size does so over the lamp.
"""
