"""A source that changed, and what the user had made of its last import: nothing is lost, nothing is silent.

record.py          what a scene was imported from and as: `X.imported.json` beside it
merge.py           three values -> one (last imported, new import, the user's), and a report of each decision
merge_scene.py     scenes: nodes known by their paths of names
merge_material.py  materials: parameters, textures and features one by one
merging.py         folders: a new import + the user's -> a folder to open, with its own record

base (record) ──┐
new import ─────┼─> merged scene + materials, Report(kept, taken, conflicts, orphans)
the user's ─────┘
"""
