"""A frame = views + passes. May import everything of the engine but app and experiments.

camera.py       Camera: where from and how wide           settings.py  RenderSettings: one declaration, all doors
view.py         View = camera + size + settings           facts.py     SceneFacts: what this scene has
transforms.py   node rows -> camera-near float32 rows      draw_list.py instances -> batches of indirect commands
palettes.py     skins -> rows per joint                    morphs.py      targets in use, weights per object
light_rows.py   light table -> Light structs, bounds       view_block.py  the uniform block all shaders see
light_tables.py fitted lobes of area lights, IES profiles  lighting.py    by which path local lights reach surfaces
gbuffer.py      what a surface is packed into              light_lists.py buffers behind the light lists of tiles
occlusion.py    which ambient occlusion a view has, how far it looks
gi/             light from surface to surface and reflections: which a view has, layers, gather, what is kept
bloom.py        how widely a lens scatters light        exposure.py  what the eye of each view has got used to
focus.py        how wide a point out of focus is        temporal.py  which frames a TAA picture is gathered from
motion/         the frame before of each view: where everything was, and when that tells anything (conventions)
presets.py      sets of settings from quick to good     look.py      what a frame shows besides surfaces and lights
scene_rows.py   what the device holds of a scene        frame_facts.py, light_path.py: the facts of a frame
depth_range.py  how deep an orthographic view is drawn
light_groups.py what lights reach, one by one and in groups of neighbours
passes/         one pass a file, its shader of the same name in shaders/passes
shadows/        cascades of the first sun, tiles of point and spot lights: fit, bias, who casts
paths/          which passes make a frame, and which path is the cheapest
draw_states.py  what a batch binds, and its order; draw_commands.py: indirect commands of what is drawn
programs.py     pipelines of batches; variant_requests.py: what they ask of the library; pass_programs.py: of passes
effect_programs.py  pipelines of batches in roles beside the picture's own: motion, layers, tints
blocks.py       generated GLSL in front of shaders;   ahead.py: programs made in slices while the last picture stays
hysteresis.py   facts that flicker stay on for a while
nonfinite.py    beside the graph, on demand: which pass made the first NaN, and where
peek.py         beside the graph, on demand: one target's texels in the middle of a frame
background_bakes.py    surroundings baked in a thread, where who draws must not wait
renderer.py     Renderer.render(scene, view) -> Frame

scene tables ─► facts ─► hysteresis ─► frame graph (compiled once per facts) ─► passes ─► rgba8 picture + FrameStats
           └─► transforms, lights, visibility ─► draw list ─────────┘
"""
