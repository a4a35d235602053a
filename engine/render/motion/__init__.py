"""Motion: where what a pixel shows was in the frame before, and when that frame tells something about this one.

May import what engine.render may.

before.py    the frame before of each view: camera, rows of transforms, palettes, morph weights; cuts
frame.py     FrameMotion: what a frame knows of it, for passes (RenderFrame.motion)
request.py   what a batch asks of the effect library to draw how far it moved
jitter.py    where in its pixel a frame looks

    view + scene rows ─► before.begin ─► FrameMotion ─► passes/motion.py ─► texture "motion"
                             ▲                              depth + both cameras, for everything that stands still
    frame made ─► before.end ┘                              drawn with the rows of before, where something moved

Conventions, for all that is reprojected (TAA, light between surfaces, occlusion, shadows):

- `motion` is rg16f, in pixels, x to the right, y down, of the nearest solid surface, sky included: what is seen at
  pixel p (its middle) was at p - motion. Jitter is in neither of the two places. Where a camera and all things stand
  still it is 0 to the bit. What was behind the camera has a motion of NOWHERE pixels: outside of every picture.
- Blended surfaces have the motion of what is behind them. Effects that place vertices by stages of their own need a
  technique for the role `motion`, or have the motion of things that stand still.
- A pass that keeps something from frame to frame declares it with `Builder.history`. `PassContext.history_reset` says
  that there is nothing to be had: in the first frame, after a change of size, scene, path or projection, after a cut or
  a frame that was given up, and in every picture that must depend on nothing but the scene (`View.seconds` is None).
- A cut is what the caller says is one (`View.cut`), and a camera that turned or went too far in a frame (before.CUT_*).
- Nothing here costs anything where no fact says `motion`: rows of before are kept for views that want them only.
"""
