"""From clips' keys to node transforms, of one scene or a thousand characters. May import math, assets, scene.

    ClipAsset ─ tracks.pack ─> Track per (path, interpolation), checked, concatenated
                                 │
    time_s ─ clock.wrap ─> clip time ─ sample ─> values f8[k,3|4] ─ ClipPlayer.apply ─> NodeTable columns

    *.animation.toml ─ animation_file ─> AnimationGraph (Rig, clips, states, blend spaces, layers, masks)
                                           │
    dt ─ state_machine, playhead ─> Step ──┼─ events.crossings ─> Fired: markers, once each
                                     │     └─ root_motion.travel ─> the characters' way
                                     └─ mixing: ClipSampler ─ BlendJob ─ LayerJob ─> poses f8[10,m,n]
                                                                                       │
                                             NodeTable columns <─ Animator.write ──────┘

    tracks of the same file ─ sequence.Sequence: a pure function of time ─> poses, way, markers' times
    transport: a playhead over seconds, in and out points, markers passed once each

    ClipAsset ─ compress (key_reduction, 16 bits) ─> ClipAsset of coded channels, within an error stated in metres at
    the skin; decoded when a clip first plays
    weights channels ─ morph.WeightPlayer ─> MorphTable
    pose, skinning, morph: nodes, clip, time -> meshes in world space on the CPU, for export and as truth

No Python loop runs over characters, nodes or channels in a frame: only over clips, states and layers.
"""
