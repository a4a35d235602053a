// Counts what is no number in one level of a texture and marks where it is; or, with FETCH, fetches the first one found.
// Bit tests: a compiler may assume that isnan() never holds.
layout(local_size_x = GROUP_X, local_size_y = GROUP_Y) in;

#if KIND == 0
layout(binding = 10) uniform sampler2D t_checked;
vec4 texel(ivec3 at, int s) { return texelFetch(t_checked, at.xy, job.level); }
#elif KIND == 1
layout(binding = 10) uniform sampler2DMS t_checked;
vec4 texel(ivec3 at, int s) { return texelFetch(t_checked, at.xy, s); }
#elif KIND == 2
layout(binding = 10) uniform sampler2DArray t_checked;
vec4 texel(ivec3 at, int s) { return texelFetch(t_checked, at, job.level); }
#else
layout(binding = 10) uniform sampler3D t_checked;
vec4 texel(ivec3 at, int s) { return texelFetch(t_checked, at, job.level); }
#endif

layout(binding = 0, r32ui) uniform uimage2D i_marks;

uvec4 magnitude(vec4 v) { return floatBitsToUint(v) & 0x7fffffffu; }
bool has_nan(vec4 v) { return any(greaterThan(magnitude(v), uvec4(0x7f800000u))); }
bool has_inf(vec4 v) { return any(equal(magnitude(v), uvec4(0x7f800000u))); }

#if FETCH
void main()
{
    uint first = records[job.record].first;
    if (first == 0xffffffffu || any(notEqual(gl_GlobalInvocationID, uvec3(0u)))) return;
    uint width = uint(job.size.x), height = uint(job.size.y);
    ivec3 at = ivec3(first % width, (first / width) % height, first / (width * height));
    for (int s = 0; s < job.samples; ++s) {
        vec4 v = texel(at, s);
        records[job.record].value = v;
        if (has_nan(v) || has_inf(v)) return;
    }
}
#else
void main()
{
    ivec3 at = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(at, job.size))) return;
    uint found = 0u;
    for (int s = 0; s < job.samples; ++s) {
        vec4 v = texel(at, s);
        found |= has_nan(v) ? 1u : 0u;
        found |= has_inf(v) ? 2u : 0u;
        if (job.radiance != 0u) {
            found |= any(lessThan(v.rgb, vec3(0.0))) ? 4u : 0u;
            found |= any(greaterThan(v.rgb, vec3(job.highest))) ? 8u : 0u;
        }
    }
    if (found == 0u) return;
    if ((found & 1u) != 0u) atomicAdd(records[job.record].nan_count, 1u);
    if ((found & 3u) == 2u) atomicAdd(records[job.record].inf_count, 1u);
    if ((found & 4u) != 0u) atomicAdd(records[job.record].negative, 1u);
    if ((found & 8u) != 0u) atomicAdd(records[job.record].over, 1u);
    if ((found & 3u) != 0u) {
        uint index = (uint(at.z) * uint(job.size.y) + uint(at.y)) * uint(job.size.x) + uint(at.x);
        atomicMin(records[job.record].first, index);
    }
    if (job.marks != 0u) {
        vec2 part = (vec2(at.xy) + 0.5) / vec2(job.size.xy);
        imageAtomicOr(i_marks, ivec2(part * vec2(imageSize(i_marks))), found);
    }
}
#endif
