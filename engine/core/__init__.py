"""The ground floor: errors with a place, findings, parameters, paths, atomic files. Imports only the standard library.

errors    LucarnaError tree, Place (file:line:column, object path), exit codes
findings  what an import or check noticed
param     Param / ParamBlock: declare once -> UBO, slider, CLI flag, docs
paths     data_root(), shaders_dir(), template_dir(), user_cache_dir()
watched   Watched: which of many files changed, by mtime and size
atomic    atomic_path(), write_bytes(), write_text()
"""
