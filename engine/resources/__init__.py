"""Residency: engine files become GPU residents. May import materials, gpu, assets, core.

arena.py           MeshArena: one set of vertex streams + one index buffer per vertex layout
texture_pool.py    TexturePool: texture arrays by (format, size, mips), so that batches do not split
texture_files.py   TextureFiles: texture files as layers of the pool, read again when they change on disk
procedural.py      ProceduralTextures: slots that an effect's compute stages fill, again only where a parameter changed
material_store.py  MaterialStore: a row per material in its effect's table, its texture group, its queue
environment.py     EnvironmentMap: the prefiltered cube, its SH9 irradiance, the DFG table
hot_reload.py      HotReload: edited effects, shaders, materials, textures to the screen; the last good picture stays
samples.py         sample_scene: a scene made by code, straight from memory
residency.py       Residency: paths -> ids, loads once, replaces what fails by magenta and says so

.lmesh ──► MeshArena ──┐
.dds ► Files ► TexPool ┼─► Residency (mesh ids, material ids) ──► engine.render
.material.toml ► Store ┘
"""
