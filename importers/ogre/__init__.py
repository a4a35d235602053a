"""Ogre 3D (1.x) files: meshes, skeletons, material scripts. Own readers, numpy and expat; needs nothing of Ogre.

sniff, sources   which of the four files it is              data         OgreMesh, OgreSkeleton: as in the file
chunks           bounds-checked bytes, either endianness    xml_reader   checked elements of the XML twins
mesh_binary      .mesh      (vertices: declarations)        mesh_xml     .mesh.xml
skeleton_binary  .skeleton                                  skeleton_xml .skeleton.xml
script           .material text -> objects                  inheritance  parents merged, variables filled in
folders          scripts and images around a mesh           resolver     a material by its name, with its images
materials, units an Ogre material -> the `surface` effect   reader       all of it -> ImportedModel
skeletons, animations, morphs, build   joints, clips, morph targets, vertices and indices

x.mesh -> OgreMesh -+- skeletons (linked ones too) -> joints, bind pose, clips ---+
                    +- folders -> script -> inheritance -> materials, images -----+-> ImportedModel
                    +- build: parts, tangents, influences, morph targets ---------+
"""
