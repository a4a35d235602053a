// What a flat mirror shows (engine/render/planar): the picture from behind its plane, in which a point of the plane lies as
// far left as it lies right here. Needs v_position.
layout(binding = 30) uniform sampler2DArray t_planar;        // premultiplied by how much of a texel shows a body
layout(binding = 31) uniform sampler2DArray t_planar_depth;

// Spread of a mirrored lobe: its deviation in radians, of alpha (engine/experiments/planar.py fits it)
const float PLANAR_SPREAD = 1.0;
// Deviation of what a mip of level 0 shows, read between its texels
const float PLANAR_TEXEL = 0.5;

int planar_mirror(vec3 p, vec3 n)
{
    for (int i = 0; i < int(planar.mirrors); ++i) {
        vec4 plane = planar.planes[i];
        if (abs(dot(plane.xyz, p) + plane.w) <= planar.near[i] && dot(plane.xyz, n) > 0.7) return i;
    }
    return -1;
}

// Metres from p along the mirrored view to what the picture shows at uv; -1: nothing.
float planar_way(int mirror, vec2 uv, vec3 p)
{
    ivec2 size = textureSize(t_planar_depth, 0).xy;
    ivec2 texel = clamp(ivec2(uv * vec2(size)), ivec2(0), size - 1);
    float depth = texelFetch(t_planar_depth, ivec3(texel, mirror), 0).r;
    if (depth <= 0.0) return -1.0;
    if (view.camera.w < 0.5) return max(gl_FragCoord.z - depth, 0.0) * length(view.place_z.xyz);
    // depth is near / view depth in both pictures, and p is as deep in either
    return length(view.camera.xyz - p) * max(gl_FragCoord.z / depth - 1.0, 0.0);
}

// Light that a surface mirrors: of bodies from the picture, else `radiance`, the environment's. a: how far it holds; 0 where
// the surface is too rough or in no mirror. n: normal that mirrors; smooth_n: that of the mesh.
vec4 planar_light(vec3 radiance, vec3 n, vec3 smooth_n, vec3 v, vec3 p, float roughness)
{
    float part = 1.0 - smoothstep(0.75 * planar.roughness, planar.roughness, roughness);
    int mirror = part > 0.0 ? planar_mirror(p, smooth_n) : -1;
    if (mirror < 0) return vec4(0.0);
    vec4 plane = planar.planes[mirror];
    vec2 uv = vec2(1.0 - gl_FragCoord.x * view.size.z, gl_FragCoord.y * view.size.w);
    float way = planar_way(mirror, uv, p);
    float eye = view.camera.w > 0.5 ? length(view.camera.xyz - p) : 1.0;
    if (dot(n, plane.xyz) < 0.999999) {
        // a wave turns the ray: to where it meets what the flat mirror shows here
        vec3 r = reflect(-v, n);
        r = normalize(r + plane.xyz * max(0.02 - dot(r, plane.xyz), 0.0));
        vec3 q = p + r * (way < 0.0 ? 1e3 * eye : way);
        q -= 2.0 * (dot(plane.xyz, q) + plane.w) * plane.xyz;
        vec4 clip = view.clip_from_origin * vec4(q, 1.0);
        if (clip.w > 0.0) uv = vec2(0.5 - 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w);
    }
    // how many texels the lobe is wide where it meets something
    float rough = max(roughness - MIN_ROUGHNESS, 0.0) / (1.0 - MIN_ROUGHNESS);
    float far = way < 0.0 ? 1e3 * eye : way;
    float texel = length(view.place_y.xyz) * 2.0 * view.size.w / planar.per_pixel * (view.camera.w > 0.5 ? eye + far : 1.0);
    float wide = PLANAR_SPREAD * rough * rough * far / max(texel, 1e-30);
    float level = min(log2(max(wide / PLANAR_TEXEL, 1.0)), planar.levels);
    vec4 seen = textureLod(t_planar, vec3(uv, float(mirror)), level);
    return vec4(seen.rgb + (1.0 - sat(seen.a)) * radiance, part);
}
