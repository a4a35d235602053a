"""Planar reflections: flat surfaces whose material asks for it (feature `planar_reflection`) mirror the scene itself.

parts.py     flat parts of a mesh: where its triangles share a plane
planes.py    of all that ask, the planes that a view's mirrors lie in: the largest in the picture, at most N
camera.py    the eye behind a mirror                    mirrors.py  Mirrors: what each of them sees, and the blocks
programs.py  pipelines that draw it                     choice.py   whether a view has any, how large their pictures are

meshes ─► parts ─► planes (merged over instances) ─► eye behind each ─► passes/planar_reflections.py draws what it sees
surface shading (shaders/lib/planar.glsl) finds its plane by where it is, and looks up the pixel opposite

The eye behind a mirror sees its picture the wrong way round, so that it is a camera like any other: no winding turns,
and the place of a pixel is the same with left and right exchanged. What is behind the plane is cut by gl_ClipDistance:
the oblique near plane of Lengyel (2005) has no room in a reversed, endless projection. Mirrors in mirrors show the
environment: one picture per plane, none of them in another. What a mirror shows is shaded by all lights, of many by
light lists of its own, without ambient occlusion, light between surfaces or several samples a pixel. Where the sun's
cascades do not reach, beyond what the camera sees, it casts no shadow in a mirror. What an effect moves in tessellation
or geometry stages is not cut at the plane; skinned and morphed bodies are no mirrors, but are seen in them.

Atrium, 1,024 lamps, 480x270, software rasteriser on two cores, milliseconds: frame without 413; the mirror 286, of half
the width 97; by all lights instead of lists 4,547 and 986.
"""
