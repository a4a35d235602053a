"""Lone images as sources: pictures, cube maps, arrays and environments. May import engine and the importers' textures.

grouping.py   which files belong together (six faces, numbered layers), and what a lone image is to become
lone.py       files -> TextureAsset: encoded by role, or as stored where a .dds or .ktx2 already has GPU blocks
reader.py     `load(path) -> ImportedModel` with the texture in `lone`, shown on a card or as the environment

file(s) -> grouping -> lone -> <name>.dds (+ a scene that shows it)
"""
