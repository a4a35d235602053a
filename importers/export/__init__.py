"""Scenes and sources back out to other formats. May import the importers' readers and the engine; imports no GPU.

source         what is exported: an engine scene or a source, at rest, at a moment, or with its clips
glb            the same as glTF 2.0 binary: meshes, skins, clips, morphs, materials, cameras, lights, hierarchy
glb_writer     buffers, accessors and the container
glb_materials  materials and textures as glTF has them
obj            posed geometry as Wavefront OBJ

SCENE | FILE -> source -> (pose) -> glb | obj -> one file, written atomically
"""
