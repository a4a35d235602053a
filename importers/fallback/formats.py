"""Which extensions are read here, by whom, and what their files leave unsaid."""

from __future__ import annotations

#: read by trimesh where there is no Assimp, or where it refuses
TRIMESH = (".obj", ".stl", ".ply", ".off", ".dae")
#: read by Assimp alone
ASSIMP = (
    ".3ds", ".ase", ".x", ".blend", ".lwo", ".lws", ".lxo", ".ac", ".ms3d", ".md2", ".md3", ".md5mesh", ".mdl",
    ".smd", ".b3d", ".cob", ".scn", ".irr", ".irrmesh", ".ogex", ".q3o", ".q3s", ".nff", ".dxf", ".amf", ".3mf",
    ".x3d", ".wrl", ".bvh", ".m3d", ".iqm", ".mdc", ".hmp", ".xgl", ".zgl", ".zae", ".ifc", ".ndo", ".ter", ".csm",
)  # fmt: skip
EXTENSIONS = (*TRIMESH, *ASSIMP)
#: their vertex colours are bytes for a screen, or copies of such
SRGB_COLORS = (".obj", ".ply", ".off", ".stl", ".3mf", ".amf", ".x3d", ".wrl")
#: they have no unit and no axis of their own: taken as metres and +Y up unless the settings say otherwise
UNITLESS = (".obj", ".stl", ".ply", ".off")
#: they say both, and Assimp keeps to it: what the settings say does not count
COMPLETE = (".dae", ".zae")
#: facets are what such files are about: no smoothing across edges beyond this, in degrees
CREASE_DEGREES = 60.0
