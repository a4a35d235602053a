"""Our own file formats: what they hold (dataclasses), how they are read, written and checked. May import core, math.

    mesh.py     MeshAsset, Submesh, Skeleton      lmesh.py        .lmesh   (safetensors, memory-mapped)
    clip.py     ClipAsset, Channel                lanim.py        .lanim   (safetensors, memory-mapped)
    texture.py  TextureAsset, FORMATS             dds.py          .dds     (DX10 header, mips, cubes, arrays)
    material.py MaterialAsset, TextureRef         material_toml.py *.material.toml
    scene.py    SceneAsset, NodeAsset …           scene_json.py   *.scene.json (one node a line)
    ies.py      PhotometricProfile: foreign, but read as it is, since a luminaire's maker signs for its bytes
    prefab.py   a scene that stands in others; prefab_clips.py: what it plays there
    samples/    scenes made by code: walker, atrium, poles
    environment_dds.py  baked environments: a prefiltered cube with SH9 in its extras

    quantized.py: vertex streams of an .lmesh in 16 bits of their box, where a mesh asks for it
    key_codes.py: keys of an .lanim in 16 bits, where the error that was allowed lets them be

    mapping.py (mapped files), container.py (safetensors), dds_legacy.py (old pixel formats), records.py (dataclasses
    from and to JSON) serve the readers.

    source -> importers -> [these dataclasses] -> write -> file -> read (checked, mapped) -> resources -> GPU

Readers check header, sizes and ranges before use and never trust a count; writers are atomic and give the same bytes
for the same input.
"""
