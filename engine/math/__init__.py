"""Numpy kernels of geometry, colour and shading: functions on batches, no classes. May import core only.

    quat, transform     rotations and affine transforms          ┐
    projection, frustum clip_from_view, planes, sphere tests     ├─> scene, animation, render
    bounds              boxes and spheres, also transformed      ┘
    color, tonemap      sRGB, AgX, ACES, Neutral                 ┐
    sphere, sh          directions, sampling, SH9                ├─> importers (baking), tests (twins of the shaders)
    ggx                 D, V, F, DFG, multiple scattering        ┘
    microfacet, sheen, thin_film   further D, F, V; cloth; iridescence: twins of shaders/lib ┐
    lobes               what a whole material reflects           ─> materials (explorer)    ┘
    glare               halos of bright light in float64         ─> experiments, tests
    ltc                 area lights: the fit, form factors       ─> shaders/data/ltc.dds (packaging/make_ltc.py), tests
    photometry, blackbody   lumen, lux, nit; the colour of heat  ─> scene, editor

Conventions. Right-handed, +Y up; metres, radians. Column vectors: `v_world = world_from_local @ v_local`; matrices are
[..., 4, 4] row-major float64 and named target_from_source. Quaternions are xyzw, unit. A camera looks along its local
-Z. Clip space: y up, z in [0, 1] with near = 1 and far = 0 (reversed). Every leading axis broadcasts; results are
float64 unless said otherwise.
"""
