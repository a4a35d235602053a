"""Numpy kernels on vertex and index arrays, for every importer. Pure functions of arrays; may import nothing of ours.

    topology   strips, fans, loops -> plain triangles and lines; zero-area triangles found
    triangulate  polygons of any size -> triangles
    normals    flat normals where the source has none
    tangents   tangent frames as MikkTSpace makes them
    crease     normals that are smooth up to an angle
    vertex_order  triangles for the vertex cache and against overdraw, vertices as they are used; ACMR, ATVR
    quantize   float -> snorm16, unorm16
    skin       influences sorted, cut to eight, renormalised to exactly 1

Indices stay u4: the engine's index buffers hold nothing else. Misses per triangle of a FIFO cache of 16, before, in
cache order, and in overdraw order: BrainStem 1.76, 0.70, 0.80; CesiumMan 2.08, 0.86, 0.94; ogrehead 1.74, 0.70, 0.79;
DamagedHelmet, all seams, 1.07, 1.01, 1.07; 2 to 3 microseconds a triangle.

Functions that must split vertices return `source`: for each new vertex, the old one it copies.
"""
