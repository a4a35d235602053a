"""Animation clips: from keys to node transforms. May import math, assets, scene.

    ClipAsset ─ tracks.pack ─> Track per (path, interpolation), checked, concatenated
                                 │
    time_s ─ clock.wrap ─> clip time ─ sample ─> values f8[k,3|4] ─ ClipPlayer.apply ─> NodeTable columns

    morph, skinning, pose    the same on the CPU: nodes, clip, time -> meshes in world space, for export and as truth

No Python loop runs over nodes or channels in a frame: each track is searched and interpolated as one batch.
"""
