"""Error against run time: one small file per experiment, registered by being there. May import all of the engine.

    <name>.py     EXPERIMENT = Experiment(method, truth, metric, knobs, default, orders, run)     one file each
        │  harness.registry finds it
    harness.sweep run(ctx, knobs) -> Trial: work (timed, interleaved with all others) + judge (error against the truth)
        │
    engine.report records ─> JSON twin, engine.report.page ─> one HTML page

    harness/experiment  what a file declares        harness/references  truths, cached by hash and seed
    harness/context     what a run gets             harness/shader_eval GLSL functions over arrays
    harness/clock       wall time round a finish, or GPU timestamps
    harness/scenes      scenes to measure on: files, made ones (harness/samples), the one open in an editor
    harness/live        the same runs in small steps, for an editor's panel
    truth/              ground truth by rays: visibility, ambient occlusion, path-traced pictures

What lies above the engine (opening scenes, baking) comes in through `Context.tools`, which the command line fills.
"""
