"""Effects and materials: what a surface looks like, as data. May import assets, gpu, core; never scene or framegraph.

    effect.py    Effect: features, params, texture slots, techniques; load_effect()
    schema.py    the *.effect.toml schema (pydantic); mistakes with file:line:col, caret and did-you-mean
    merge.py     `extends`, and which file each key came from
    glsl.py      generated GLSL: MaterialParams, MaterialBlock, samplers, sample_<slot>()
    features.py  resolve_features(): which features a material on a mesh switches on, and why
    library.py   EffectLibrary: variants (pipelines), hot reload
    variant.py   VariantRequest, Variant; compiling one
    fit.py       what of a material an edited effect can still take
    table.py     MaterialTable: the materials of an effect as rows of a storage buffer

    *.effect.toml --schema--> Effect --row_layout--> MaterialTable.rows --> storage buffer (binding 2)
                                 |                       ^
                                 |               MaterialAsset (*.material.toml)
                                 +--glsl(features) + *.vert, *.frag --> EffectLibrary.pipeline --> Pipeline

A feature is a macro of the same name in upper case, always defined, 0 or 1. So are UV1 and UV_TRANSFORM (a texture
reads the second uv set; is transformed), ROLE_<ROLE> and HAS_<STREAM> (the mesh's vertex streams).
"""
