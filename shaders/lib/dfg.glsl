// The split-sum table (Karis 2013, "Real Shading in Unreal Engine 4", pp. 4-7): the albedo of GGX is f0 * x + f90 * y.
layout(binding = 9) uniform sampler2D t_dfg;

// Where 0..1 lies in a table whose first and last texels stand for 0 and 1.
vec2 rim(vec2 at, float size) { return (at * (size - 1.0) + 0.5) / size; }

vec2 split_sum(float n_dot_v, float perceptual_roughness)
{
    return textureLod(t_dfg, rim(vec2(n_dot_v, perceptual_roughness), float(textureSize(t_dfg, 0).x)), 0.0).rg;
}
