// Boxes about 32 lights each, those of one word of a mask: engine/render/light_groups.py. For the stages of culling.
layout(std430, binding = 0) readonly buffer LightGroupBlock { vec4 light_groups[]; };

// Whether any light of the word can reach what lies between the planes and depths of `f`.
bool group_meets(uint word, Frustum f)
{
    vec3 lo = light_groups[2u * word].xyz;
    vec3 hi = light_groups[2u * word + 1u].xyz;
    for (int k = 0; k < 4; ++k) {
        vec3 corner = mix(lo, hi, greaterThan(f.planes[k].xyz, vec3(0.0)));
        if (dot(f.planes[k].xyz, corner) + f.planes[k].w < 0.0) return false;
    }
    vec3 axis = -vec3(view.view_from_origin[0].z, view.view_from_origin[1].z, view.view_from_origin[2].z);
    float depth = view_depth(0.5 * (lo + hi));
    float half_depth = dot(abs(axis), 0.5 * (hi - lo));
    return depth + half_depth >= f.near && depth - half_depth <= f.far;
}

bool group_meets_box(uint word, vec3 lo, vec3 hi)
{
    return all(lessThanEqual(light_groups[2u * word].xyz, hi)) && all(greaterThanEqual(light_groups[2u * word + 1u].xyz, lo));
}
