"""Error against run time: one small file per experiment, registered by being there. May import all of the engine.

    method x knobs ─> runs, interleaved ─> time (median, IQR, n) ┐
    ground truth ───> metrics of engine.report ─> error ─────────┴─> work-precision diagram: HTML page and JSON twin

An experiment names its method, its knobs, its truth, its metrics and the order of convergence it expects.
"""
