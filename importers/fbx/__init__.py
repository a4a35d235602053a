"""FBX, binary and ASCII, read by ufbx in a worker process. May import engine.assets, engine.math, importers.geometry.

    worker process (extract.py, native.py)              host
    ufbx: file -> scene in metres, +Y up           ┌─> document.py   checks what the worker sent
      nodes, meshes, skins, shapes, materials,     │     ├─ nodes, clips, skins, meshes, materials, textures
      lights, cameras, baked animation             │     └─> reader.py: ImportedModel
      -> JSON + arrays ────────────────────────────┘

`diagnose.py` says where a file that ufbx refuses is broken. The document and what builds a model of it (ModelBuilder)
serve importers.fallback, too.

ufbx's Python binding (0.0.5) hands out objects without counting references, and crashes when they are used twice or
freed; `native.py` works around that, and one process per file keeps the rest harmless.
"""
