"""Everything foreign becomes ours here. May import the engine, never the editor; the only home of foreign formats.

    registry   extension and content -> Importer          gltf/      glTF 2.0 and GLB, own reader (json + numpy)
    model      ImportedModel, the neutral in-memory form   geometry/  topology, normals, tangents, weights
    settings   ImportSettings, presets and limits          textures/  decode, encode to BCn DDS, environment maps
    presets    settings of a source: project, preset, sidecar, flags      farm/   many sources, nothing done twice
    contents   any file as meshes, clips, materials … (inspect, budgets)   cache_store   a cache that machines share
    convert    one source -> our files, all or nothing     cli/       the `lucarna` command
    cache      source -> converted folder, by content      fbx/       FBX, by ufbx in a worker process
    export/    scenes and sources back out as GLB and OBJ  workers/   tasks in processes of their own, with limits
    checks/    rules, budgets and SARIF of `check`         images/    lone images: pictures, cubes, arrays, environments
    loose_textures  materials from files' names            experiments/   error against time, for `lucarna report`
    processing what is done to every model: clean, order   ogre/      Ogre 3D meshes, skeletons, material scripts
    project/   files that name each other; `mv`            reimport/  a new import merged with what the user did
    adjusting  size, axes, uvs, normals as the user wants them
    brdf_sheet   a material's lobe as a picture (`inspect --brdf`)
    key_reduction, lods   fewer keys, fewer triangles      fallback/  all other formats, by Assimp or trimesh

    X.glb -> registry -> gltf.load -> ImportedModel (arrays + findings) -> convert -> .lmesh .lanim .dds
             .material.toml .scene.json, staged in a temporary folder and moved into place at the end

Findings are collected, never printed here: whatever is sound is imported, the rest is named.
"""
