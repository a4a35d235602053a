"""Images become GPU textures here. May import engine and importers.settings; the home of Pillow, ispc and OpenEXR.

image.py    bytes -> u1/u2[h,w,4] or f4[h,w,3]     limits before decoding, colour space by role, never by chunk
hdr.py      .hdr, .exr, DDS cubes -> radiance f4   psd.py, png16.py   what Pillow reads in part only
ktx2.py     KTX2 -> TextureAsset                   pixels.py, png.py  TextureAsset -> pixels -> PNG
packing.py  roughness + metalness -> one image     toksvig.py         roughness for bumps that a mip cannot show
mips.py     resample in linear light, normals renormalised, alpha coverage kept
encode.py   pixels + role + settings -> TextureAsset (BC4 BC5 BC6H BC7 by ispc_texcomp, or uncompressed)
blocks.py   the ispc calls: padded, packed as each wants it, split over threads
cube.py, procedural.py, ggx_tables.py, environment.py     environment -> prefiltered cube + SH9, DFG table

bytes -> decode -> mips (linear) -> encode -> TextureAsset -> engine.assets.dds
"""
