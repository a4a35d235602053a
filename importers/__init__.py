"""Everything foreign becomes ours here. May import the engine, never the editor; the only home of foreign formats.

    registry   extension and content -> Importer          gltf/      glTF 2.0 and GLB, own reader (json + numpy)
    model      ImportedModel, the neutral in-memory form   geometry/  topology, normals, tangents, weights
    settings   ImportSettings, presets and limits          textures/  decode, encode to BCn DDS, environment maps
    convert    one source -> our files, all or nothing     cli/       the `lucarna` command
    cache      source -> converted folder, by content      fbx/       FBX, by ufbx in a worker process
    export_obj posed geometry back out as OBJ              workers/   tasks in processes of their own, with limits

    X.glb -> registry -> gltf.load -> ImportedModel (arrays + findings) -> convert -> .lmesh .lanim .dds
             .material.toml .scene.json, staged in a temporary folder and moved into place at the end

Findings are collected, never printed here: whatever is sound is imported, the rest is named.
"""
