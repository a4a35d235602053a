"""What was measured: timers, statistics, image errors, image files, reports. May import core only (Pillow etc. lazily).

timers   CpuTimer, PassTimes            ─> stats      FrameStats (one frame: passes, counters) ─> JSON, overlays
summary  median, IQR of repeated runs   ─> benches, experiments
plot_sheet   curves and polar slices as a picture
metrics  rmse, rel_mse, psnr, is_blank  <─ image      PNG and EXR in and out, atomic, same bytes for the same pixels
         angles, energy                    perceptual FLIP, SSIM (the extra `report`)
picture_difference   how two pictures differ, in numbers and as a map

number_check  what the check of a frame's numbers found: NaN and infinities, pass by pass

interleave, interval, front, order      ─> records    Report: experiments, points, floors, orders, omissions
    runs in turns, bootstrap, Pareto,         │
    slopes, crossover                         ├─> writing, page/  report.html and report.json
                                              ├─> compare         two report.json
                                              └─> advice          which setting to take, what another costs and gives
"""
