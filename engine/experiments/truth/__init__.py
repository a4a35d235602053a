"""Ground truth by ray tracing: visibility, ambient occlusion, and whole pictures. Embree's rays, our own shading.

    Scene + Residency ─ triangles ─> Triangles ─ rays (embree) ─┬─> visibility   part of a disc seen, ambient occlusion
                                                                │
    WORLD_LIGHT ────── lamps ─ one sample each ─────────────────┼─> traced_scene ─> path_tracer  Film: mean f8[h,w,3],
    EnvironmentMap ─── surroundings ─ importance-sampled cube ──┤        lobes         two halves, noise
    MaterialAsset ──── surfaces, texels ─ values where rays hit ┘   diffuse + GGX + multi-scatter

    reference   a path-traced picture out of the cache, or made piece by piece

May import the engine below `app`. Needs the package embreex (extra `report`); without it `rays.missing()` says so.
"""
