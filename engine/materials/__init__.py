"""Effects and materials: what a surface looks like, as data. May import assets, gpu, core; never scene or framegraph.

    effect.py        Effect: features, params, texture slots, techniques; load_effect()
    schema.py        the *.effect.toml schema (pydantic), all its words; mistakes with file:line:col and did-you-mean
    state_schema.py  the words of state groups and sampler groups
    technique.py     Technique: levels, passes, stages, state, with what they inherit filled in
    requirements.py  what a level may require of a device; which one is chosen
    roles.py         what passes ask for; names of their targets; what stands in for a role that an effect has not
    condition.py     `when`: under which condition a parameter matters
    explain.py       levels, passes and absent roles in words, for `inspect` and `--explain`
    merge.py         `extends` (engine.core.toml_merge)
    glsl.py          generated GLSL: MaterialParams, MaterialBlock, samplers, sample_<slot>()
    features.py      resolve_features(): which features a material on a mesh switches on, and why
    library.py       EffectLibrary: variants (pipelines), hot reload
    variant.py       VariantRequest, Variant; compiling one
    versions.py      the last good version of an effect, and where an edit begins
    pairing.py   whether a material's microfacet terms belong together
    lobe_plots.py   curves of a material's lobe, albedo, terms: editor's explorer, `inspect --brdf`
    fit.py           what of a material an edited effect can still take
    table.py         MaterialTable: the materials of an effect as rows of a storage buffer

    *.effect.toml --schema--> Effect --row_layout--> MaterialTable.rows --> storage buffer (binding 2)
                                 |                       ^
                                 |               MaterialAsset (*.material.toml)
                                 +--glsl(features) + *.vert, *.frag --> EffectLibrary.pipeline --> Pipeline

A feature is a macro of the same name in upper case, always defined, 0 or 1. So are UV1 and UV_TRANSFORM (a texture
reads the second uv set; is transformed), ROLE_<ROLE> and HAS_<STREAM> (the mesh's vertex streams). A technique's own
macros (`defines`) come after them.

The technique of the role `texture` draws nothing: its compute stages fill texture slots that a material gives no file
for (engine.resources.procedural), again where a parameter that they name changes. glsl.py says what such a shader
sees; shaders/effects/wood.effect.toml is one.
"""
