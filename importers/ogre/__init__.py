"""Ogre 3D (1.x) files: meshes, skeletons, material scripts. Own readers, numpy and expat; imports nothing of Ogre.

chunks        bounds-checked bytes of either endianness      xml_reader    checked elements of the XML twins
mesh_binary   .mesh      ┐                                   skeleton_binary  .skeleton     ┐
mesh_xml      .mesh.xml  ┴-> data.OgreMesh                   skeleton_xml     .skeleton.xml ┴-> data.OgreSkeleton
vertices      vertex declarations of any element type -> plain columns
script        .material text -> objects, inherited and with variables set (resolve)
folders       which scripts and images lie around a mesh, by name
materials     an Ogre material -> the `surface` effect

x.mesh -> mesh_binary -> OgreMesh ─┬─ skeletons (linked ones too) -> joints, bind pose, clips ─┐
                                   ├─ folders + script -> materials + images ─────────────────┼-> ImportedModel
                                   └─ build: parts, tangents, influences, morph targets ──────┘
"""
