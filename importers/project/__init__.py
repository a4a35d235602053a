"""Files of a project and how they refer to each other. May import the engine and importers; no GPU, no window.

references.py   what a file names, and where: scenes, materials, effects, shaders, sidecars, glTF, OBJ
move_log.py     what a move had begun when its process died, put back
moving.py       `mv`: files move, every reference to them follows, all or nothing, and back again

folder -> files_of -> references(file) -> used_by / uses (the assets panel, `lucarna mv --dry-run`)
                                       -> plan(old, new) -> Move -> apply / undo
"""
