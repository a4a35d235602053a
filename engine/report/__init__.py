"""What was measured: timers, frame statistics, image errors, image files. May import core only (Pillow etc. lazily).

timers   CpuTimer, PassTimes            ─> stats    FrameStats (one frame: passes, counters) ─> JSON, overlays
summary  median, IQR of repeated runs   ─> benches, experiments
metrics  rmse, rel_mse, psnr, is_blank  <─ image    PNG and EXR in and out, atomic, same bytes for the same pixels
"""
