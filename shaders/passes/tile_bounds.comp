// What each tile shows: the nearest and farthest solid pixel, the box about them, the depths in use. Sky does not count.
// One workgroup is a bin of 4 x 4 tiles, one invocation a tile; the bin's own depths are gathered at the end.
#include "lib/light_culling.glsl"

layout(local_size_x = 4, local_size_y = 4) in;

#if SAMPLES > 1
layout(binding = 20) uniform sampler2DMS t_depth;
#else
layout(binding = 20) uniform sampler2D t_depth;
#endif
layout(std430, binding = 1) writeonly buffer TileBlock { TileBounds tile_bounds[]; };
layout(std430, binding = 4) writeonly buffer BinBlock { uvec4 bin_depth[]; };  // nearest, farthest, flags

shared uint s_near;
shared uint s_far;
shared uint s_flags;

void main()
{
    if (gl_LocalInvocationIndex == 0u) {
        s_near = 0x7f7fffffu;
        s_far = 0u;
        s_flags = 0u;
    }
    barrier();
    uvec2 tile = gl_GlobalInvocationID.xy;
    if (tile.x < view.tiles.z && tile.y < view.tiles.w) {
        ivec2 first = ivec2(tile << view.tiles.x);
        ivec2 end = min(first + (1 << view.tiles.x), ivec2(view.size.xy));
        vec3 lo = vec3(3e38);
        vec3 hi = vec3(-3e38);
        float near = 3e38;
        float far = 0.0;
        uint flags = 0u;
#if DEPTH_BINS
        // the depths alone; the boxes about pixels follow when their middle is known
        float least = 2.0;
        float most = 0.0;
        for (int y = first.y; y < end.y; ++y) {
            for (int x = first.x; x < end.x; ++x) {
                for (int s = 0; s < SAMPLES; ++s) {
                    float z = texelFetch(t_depth, ivec2(x, y), s).r;
                    bool there = z > 0.0 && z <= 1.0;
                    least = there ? min(least, z) : least;
                    most = there ? max(most, z) : most;
                    flags |= there ? 1u : 2u;
                }
            }
        }
        if ((flags & 1u) != 0u) {
            for (int k = 0; k < 8; ++k) {
                vec2 corner = vec2((k & 1) != 0 ? end.x : first.x, (k & 2) != 0 ? end.y : first.y);
                vec3 p = position_from_depth(corner, (k & 4) != 0 ? most : least);
                float d = view_depth(p);
                lo = min(lo, p);
                hi = max(hi, p);
                near = min(near, d);
                far = max(far, d);
            }
        }
#else
        for (int y = first.y; y < end.y; ++y) {
            for (int x = first.x; x < end.x; ++x) {
                for (int s = 0; s < SAMPLES; ++s) {
                    float z = texelFetch(t_depth, ivec2(x, y), s).r;
                    if (!(z > 0.0 && z <= 1.0)) {
                        flags |= 2u;
                        continue;
                    }
                    vec3 p = position_from_depth(vec2(x, y) + 0.5, z);
                    float d = view_depth(p);
                    lo = min(lo, p);
                    hi = max(hi, p);
                    near = min(near, d);
                    far = max(far, d);
                    flags |= 1u;
                }
            }
        }
#endif
        // rounding, and where a pixel has several samples, that they lie beside its middle
        float pad = 1e-5 * (far + length(max(abs(lo), abs(hi))));
#if SAMPLES > 1
        pad += 0.75 * length(view.place_x.xyz) * 2.0 * view.size.z * (view.camera.w > 0.5 ? far : 1.0);
#endif
        if ((flags & 1u) == 0u) pad = 0.0;
        near = max(near - pad, 0.0);
        far += pad;
        vec3 back_lo = vec3(3e38);
        vec3 back_hi = vec3(-3e38);
        uint bins = 0u;
#if DEPTH_BINS
        if ((flags & 1u) != 0u) {
            float middle = 0.5 * (near + far);
            lo = vec3(3e38);
            hi = vec3(-3e38);
            for (int y = first.y; y < end.y; ++y) {
                for (int x = first.x; x < end.x; ++x) {
                    for (int s = 0; s < SAMPLES; ++s) {
                        float z = texelFetch(t_depth, ivec2(x, y), s).r;
                        bool there = z > 0.0 && z <= 1.0;
                        vec3 p = position_from_depth(vec2(x, y) + 0.5, there ? z : 1.0);
                        float d = view_depth(p);
                        // chosen, not branched to: neighbours seldom agree
                        bool before = there && d < middle;
                        bool behind = there && !(d < middle);
                        bins |= there ? depth_bits(near, far, d - pad, d + pad) : 0u;
                        lo = before ? min(lo, p) : lo;
                        hi = before ? max(hi, p) : hi;
                        back_lo = behind ? min(back_lo, p) : back_lo;
                        back_hi = behind ? max(back_hi, p) : back_hi;
                    }
                }
            }
        }
#endif
        tile_bounds[tile.y * view.tiles.z + tile.x] = TileBounds(
            vec4(lo - pad, near), vec4(hi + pad, far), vec4(back_lo - pad, 0.0), vec4(back_hi + pad, 0.0),
            uvec4(bins, flags, 0u, 0u));
        if ((flags & 1u) != 0u) {
            atomicMin(s_near, floatBitsToUint(near));
            atomicMax(s_far, floatBitsToUint(far));
        }
        atomicOr(s_flags, flags);
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u)
        bin_depth[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = uvec4(s_near, s_far, s_flags, 0u);
}
