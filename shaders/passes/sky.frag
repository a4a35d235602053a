// The environment behind everything: drawn at the far plane (reversed depth 0) where nothing nearer is.
#include "lib/environment.glsl"

layout(location = 0) in vec2 v_uv;
layout(location = 0) out vec4 o_color;

void main()
{
    vec2 ndc = vec2(v_uv.x * 2.0 - 1.0, 1.0 - v_uv.y * 2.0);
    vec3 d = view.ray_center.xyz + ndc.x * view.ray_right.xyz + ndc.y * view.ray_up.xyz;
    o_color = vec4(sanitise(environment_radiance(normalize(d), sky.blur)), 1.0);
}
