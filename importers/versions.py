"""Versions that are part of every cache key. Imports nothing, so that the check of what is up to date can afford it.

Raise one whenever the same input would give other bytes; an importer's own version stands in importers/registry.py.
"""

from __future__ import annotations

#: how textures are encoded (a new ispc_texcomp encodes otherwise, too)
ENCODER_VERSION = "ispc_texcomp-1.0.1/2"
#: all that happens between an importer's model and the files: processing, names, formats
CONVERT_VERSION = f"5, textures {ENCODER_VERSION}"
