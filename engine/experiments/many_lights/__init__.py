"""What the many-lights experiment makes of its times. May import engine.render and engine.report.

    points ─► claims.py   what is said of the paths, held against the times; crossovers, slopes
    counts ─► submit.py   what a frame costs the processor, on the device that draws nothing
"""
