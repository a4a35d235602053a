// One light's share of what lies in its volume, added to the sum.
#include "lib/gbuffer_read.glsl"
#include "lib/light_bounds.glsl"
#include "lib/local_lights.glsl"
#include "lib/view.glsl"

flat layout(location = 0) in uint v_light;
layout(location = 0) out vec4 o_color;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(t_depth, pixel, 0).r;
    if (!(depth > 0.0)) discard;
    vec3 p = position_from_depth(gl_FragCoord.xy, depth);
    LightBound b = light_bound(v_light);
    vec3 to_light = b.center - p;
    if (b.radius < ENDLESS && dot(to_light, to_light) > b.radius * b.radius) discard;
    vec3 v = safe_normalize(view_vector(p));
#if THREE_PASS
    SurfaceTexels t = SurfaceTexels(texelFetch(t_gbuffer0, pixel, 0).xy, uvec2(0u), 0u);
    if (t.a.x == NO_REFLECTION) discard;
    Reflector r = unpack_surface(t, v);
    r.f0 = vec3(0.0);
    r.f90 = 0.0;
    r.diffuse_albedo = vec3(1.0);
    vec3 diffuse = light_share(v_light, p, r, uvec2(pixel));
    r.f0 = vec3(1.0);
    r.f90 = 1.0;
    r.diffuse_albedo = vec3(0.0);
    vec3 specular = light_share(v_light, p, r, uvec2(pixel));
    o_color = vec4(diffuse, dot(specular, vec3(0.2126, 0.7152, 0.0722)));
#else
    Reflector r = unpack_surface(gbuffer_texels(pixel), v);
    o_color = vec4(light_share(v_light, p, r, uvec2(pixel)), 0.0);
#endif
}
