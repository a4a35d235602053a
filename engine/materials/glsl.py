"""Generated GLSL of an effect: nobody types a binding, an offset or a padding.

struct MaterialParams { … };                                                 one field per param, four per slot
layout(std430, binding = 2) readonly buffer MaterialBlock { MaterialParams materials[]; };
layout(binding = <unit>) uniform sampler2DArray t_<slot>;                    units in declaration order (texture_unit)
vec4 sample_<slot>(MaterialParams m, vec2 uv0, vec2 uv1);

In front of a shader that computes textures (`[technique.texture]`; it has a main, called once for every texel):
struct MaterialParams, materials[]; MaterialParams material();                the values of the material it works for
ivec2 texel(); ivec2 texture_size(); vec2 texture_uv();                       where it is; uv of the texel's middle
void write_<output>(vec4 value); vec4 read_<output>(ivec2 at);                `at` wraps round: textures repeat
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from engine.gpu.glsl_layout import BlockLayout, Field, layout

if TYPE_CHECKING:
    from engine.materials.effect import Effect

#: the storage buffer with the rows of all materials of the effect
MATERIAL_BINDING = 2

#: Helper invocations (those of a 2x2 quad outside the triangle) need not see what an SSBO holds: on llvmpipe they read
#: zeros. Where the uv depends on the material, its derivatives and with them the mip would be garbage along all edges.
#: So helpers take the value of the invocations inside; neighbours' values are had from the fine derivatives.
_WITHIN_QUAD = """
#ifdef STAGE_FRAGMENT
vec4 within_quad(vec4 value)
{
    vec4 sum = gl_HelperInvocation ? vec4(0.0) : value;
    float count = gl_HelperInvocation ? 0.0 : 1.0;
    vec2 side = 1.0 - 2.0 * mod(floor(gl_FragCoord.xy), 2.0);
    sum += sum + dFdxFine(sum) * side.x;
    count += count + dFdxFine(count) * side.x;
    sum += sum + dFdyFine(sum) * side.y;
    count += count + dFdyFine(count) * side.y;
    return gl_HelperInvocation ? sum / max(count, 1.0) : value;
}
#else
vec4 within_quad(vec4 value) { return value; }
#endif"""

#: parameter type -> GLSL type; a bool is 0 or 1, an enum the index of its choice
GLSL_TYPES = {
    "float": "float", "int": "int", "uint": "uint", "bool": "uint", "enum": "uint",
    "vec2": "vec2", "vec3": "vec3", "vec4": "vec4", "color3": "vec3", "color4": "vec4",
}  # fmt: skip


def row_layout(effect: Effect) -> BlockLayout:
    """std430 layout of MaterialParams. `<slot>_row0/1`: the two rows of the uv transform, (a, b, offset, 0)."""
    fields = [Field(param.name, GLSL_TYPES[param.type]) for param in effect.params]
    for slot in effect.textures:
        fields += [
            Field(f"{slot.name}_layer", "uint"), Field(f"{slot.name}_uv", "uint"),
            Field(f"{slot.name}_row0", "vec4"), Field(f"{slot.name}_row1", "vec4"),
        ]  # fmt: skip
    return layout(fields or [Field("unused_", "uint")], "std430")


#: of the job of a technique that computes: which material, into which layer
JOB_BINDING = 1
JOB = layout([Field("size", "ivec2"), Field("material", "uint"), Field("layer", "uint")], "std140")
#: texels a work group, across and down
GROUP = 8


def generate_computing(effect: Effect, outputs: Mapping[str, str]) -> str:
    """The text in front of a compute shader; `outputs`: texture slot -> format, image units in that order."""
    parts = [
        effect.row_layout.struct_glsl("MaterialParams").rstrip(),
        effect.row_layout.buffer_glsl("MaterialBlock", MATERIAL_BINDING, "MaterialParams", "materials").rstrip(),
        JOB.block_glsl("JobBlock", JOB_BINDING, "job").rstrip(),
        f"layout(local_size_x = {GROUP}, local_size_y = {GROUP}) in;",
        "MaterialParams material() { return materials[job.material]; }",
        "ivec2 texel() { return ivec2(gl_GlobalInvocationID.xy); }",
        "ivec2 texture_size() { return job.size; }",
        "vec2 texture_uv() { return (vec2(texel()) + 0.5) / vec2(job.size); }",
    ]
    for unit, (slot, form) in enumerate(outputs.items()):
        parts += [
            f"layout(binding = {unit}, {form}) uniform image2DArray i_{slot};",
            f"void write_{slot}(vec4 value) {{ imageStore(i_{slot}, ivec3(texel(), int(job.layer)), value); }}",
            f"vec4 read_{slot}(ivec2 at)",
            "{",
            "    ivec2 wrapped = at & (job.size - 1);",
            f"    return imageLoad(i_{slot}, ivec3(wrapped, int(job.layer)));",
            "}",
        ]
    return "\n".join(parts) + "\n"


def generate(effect: Effect, features: frozenset[str]) -> str:
    """The text of a variant; `uv1` and `uv_transform` in `features` decide what sample_<slot>() does."""
    parts = [
        effect.row_layout.struct_glsl("MaterialParams").rstrip(),
        effect.row_layout.buffer_glsl("MaterialBlock", MATERIAL_BINDING, "MaterialParams", "materials").rstrip(),
    ]
    parts += [f"layout(binding = {slot.unit}) uniform sampler2DArray t_{slot.name};" for slot in effect.textures]
    if features & {"uv1", "uv_transform"}:
        parts.append(_WITHIN_QUAD.strip())
    parts += [_sampler(slot.name, features) for slot in effect.textures]
    return "\n".join(parts) + "\n"


def _sampler(slot: str, features: frozenset[str]) -> str:
    lines = [f"vec4 sample_{slot}(MaterialParams m, vec2 uv0, vec2 uv1)", "{"]
    if "uv1" in features:
        lines += [
            f"    float second = within_quad(vec4(m.{slot}_uv == 1u ? 1.0 : 0.0)).x;",
            "    vec2 uv = second > 0.5 ? uv1 : uv0;",
        ]
    else:
        lines.append("    vec2 uv = uv0;")
    if "uv_transform" in features:
        lines += [
            "    vec3 p = vec3(uv, 1.0);",
            f"    uv = vec2(dot(within_quad(m.{slot}_row0).xyz, p), dot(within_quad(m.{slot}_row1).xyz, p));",
        ]
    return "\n".join([*lines, f"    return texture(t_{slot}, vec3(uv, float(m.{slot}_layer)));", "}"])
