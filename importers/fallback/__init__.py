"""All other formats, by Assimp or trimesh in a worker process. May import engine.assets, engine.math, importers.fbx,
importers.geometry.

    formats    which extension who reads            library      Assimp's shared library, found and self-tested
    structs    its C structures                     file_access  which files it may open
    assimp_*   scene, materials, animation ──┐
    trimesh_extract  what trimesh makes of it ┼─> entries: the document of importers.fbx ─> reader ─> ImportedModel
                                              │   (nodes, polygons by corner, skins, shapes, materials, stacks)
    X.dae ─> worker ──────────────────────────┘

The document is the one that FBX comes in, so triangulation, normals, welding, weights, texture search and clips are
the same code. Both libraries are foreign: each file has a process of its own, with limits.

Who reads what, as measured on the 68 OBJ, DAE, STL, PLY and OFF files of Assimp's test models (5.2.5, trimesh 5.2):
triangle counts agree on every file that both read whole. Assimp keeps what trimesh leaves out: skins, clips, cameras
and lights of DAE (7 of 22 files come out empty without Assimp, as skinned ones do), objects and groups of OBJ (19 for
1 in spider.obj), every map of an MTL (trimesh knows the diffuse one), names of textures that are missing, normals of
STL; and it starts in 0.1 s where trimesh needs 0.6. trimesh alone reads UTF-16 DAE. So Assimp reads all of them where
it is installed, trimesh takes what Assimp refuses, and OBJ, STL, PLY and OFF (DAE with the extra `collada`) where
there is no Assimp. The key of a conversion holds which of the two, and which build, so results are never mixed.

Not imported: points and lines, textures without a place in our materials, constraints, subdivision (the cage is), and
whatever the two do not read; each is a finding.
"""
