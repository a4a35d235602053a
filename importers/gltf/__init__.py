"""glTF 2.0 and GLB by json and numpy alone. May import the importers' model and geometry, and the engine's assets.

container   file -> JSON tree + buffers (GLB chunks, data: URIs, files beside it), under limits
document    typed, checked access to the JSON tree: every wrong type becomes a finding with its json path
accessors   buffer bytes -> arrays (stride, sparse, normalised integers), bounds proven before use
meshes      primitives -> MeshAsset                 materials   materials + textures -> ImportedMaterial
nodes       the scene's tree -> NodeAsset           skins       joints and inverse binds -> Skeleton
animations  channels -> ClipAsset                   reader      all of it, in order: `load(path) -> ImportedModel`
meshopt*    compressed buffer views -> bytes        draco       compressed primitives -> accessors (by DracoPy)
light_profiles   IES files, carried along
instances   one mesh, many places -> nodes          variants    materials by variant, kept; one chosen for import
layers      KHR_materials_* layers <-> `layered`
spec_gloss  old materials -> metal/rough images     extras      what authors added, and what is ours of it

bytes -> container -> document -> { accessors -> meshes, animations; materials; nodes, skins } -> ImportedModel
"""
