"""Numpy kernels on vertex and index arrays, for every importer. Pure functions of arrays; may import nothing of ours.

    topology   strips, fans, loops -> plain triangles and lines; zero-area triangles found
    triangulate  polygons of any size -> triangles
    normals    flat normals where the source has none
    tangents   tangent frames as MikkTSpace makes them
    quantize   float -> snorm16, unorm16
    skin       influences sorted, cut to eight, renormalised to exactly 1

Functions that must split vertices return `source`: for each new vertex, the old one it copies.
"""
