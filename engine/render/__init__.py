"""A frame = views + passes. May import everything of the engine but app and experiments.

camera.py       Camera: where from and how wide           settings.py  RenderSettings: one declaration, all doors
view.py         View = camera + size + settings           facts.py     SceneFacts: what this scene has
transforms.py   node rows -> camera-near float32 rows      draw_list.py instances -> batches of indirect commands
light_rows.py   light table -> Light structs               view_block.py  the uniform block all shaders see
passes/         one pass a file, its shader of the same name in shaders/passes
shadows/        cascades of the first sun: fit, bias, who casts
paths/          which passes make a frame
renderer.py     Renderer.render(scene, view) -> Frame

scene tables ─► facts ─► frame graph (compiled once per facts) ─► passes ─► rgba8 picture + FrameStats
           └─► transforms, lights, visibility ─► draw list ─────────┘
"""
