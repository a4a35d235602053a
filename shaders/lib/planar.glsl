// What a flat mirror shows (engine/render/planar): the picture from behind its plane, in which a point of the plane lies as
// far left as it lies right here.
layout(binding = 30) uniform sampler2DArray t_planar;        // premultiplied by how much of a texel shows a body
layout(binding = 31) uniform sampler2DArray t_planar_reach;  // depth, 0 where there is nothing

// Deviation of a rough mirror's lobe, in radians, of alpha (measured: engine/experiments/planar.py)
const float PLANAR_SPREAD = 1.5;
// Deviation of what four taps between the texels of a mip show: of a box, of both tents, of the taps
const float PLANAR_TEXEL = 0.7;

int planar_mirror(vec3 p, vec3 n)
{
    for (int i = 0; i < int(planar.mirrors); ++i) {
        vec4 plane = planar.planes[i];
        if (abs(dot(plane.xyz, p) + plane.w) <= planar.near[i] && dot(plane.xyz, n) > 0.7) return i;
    }
    return -1;
}

// Metres from p along the mirrored view to the bodies that the picture shows about `at`, in a mip; -1: none. shown: how
// much of the place they fill.
float planar_way(vec3 at, float level, vec3 p, out float shown)
{
    shown = textureLod(t_planar, at, level).a;
    float depth = textureLod(t_planar_reach, at, level).r;
    if (shown < 1e-4 || depth <= 0.0) return -1.0;
    depth /= min(shown, 1.0);
    if (view.camera.w < 0.5) return max(gl_FragCoord.z - depth, 0.0) * length(view.place_z.xyz);
    // depth is near / view depth in both pictures, and p is as deep in either
    return length(view.camera.xyz - p) * max(gl_FragCoord.z / depth - 1.0, 0.0);
}

// The mip in which a lobe that has gone `way` metres is as wide as what a lookup shows. spread: its deviation, radians;
// eye: from p to the camera.
float planar_level(float spread, float way, float eye)
{
    float texel = length(view.place_y.xyz) * 2.0 * view.size.w / planar.per_pixel;
    float wide = spread * way / max(texel * (view.camera.w > 0.5 ? eye + way : 1.0), 1e-30);
    return clamp(log2(max(wide / PLANAR_TEXEL, 1.0)), 0.0, planar.levels);
}

vec4 planar_taps(vec3 at, float level)
{
    if (level <= 0.0) return textureLod(t_planar, at, 0.0);
    vec2 apart = 0.5 * min(level, 1.0) * exp2(level) / vec2(textureSize(t_planar, 0).xy);
    vec4 sum = textureLod(t_planar, at + vec3(apart, 0.0), level);
    sum += textureLod(t_planar, at - vec3(apart, 0.0), level);
    sum += textureLod(t_planar, at + vec3(apart.x, -apart.y, 0.0), level);
    sum += textureLod(t_planar, at - vec3(apart.x, -apart.y, 0.0), level);
    return 0.25 * sum;
}

// Light that a surface mirrors: of bodies from the picture, else `radiance`, the environment's. a: how far it holds; 0 where
// the surface is too rough or in no mirror. n: normal that mirrors; smooth_n: that of the mesh.
vec4 planar_light(vec3 radiance, vec3 n, vec3 smooth_n, vec3 v, vec3 p, float roughness)
{
    float part = 1.0 - smoothstep(0.75 * planar.roughness, planar.roughness, roughness);
    int mirror = part > 0.0 ? planar_mirror(p, smooth_n) : -1;
    if (mirror < 0) return vec4(0.0);
    vec4 plane = planar.planes[mirror];
    vec3 at = vec3(1.0 - gl_FragCoord.x * view.size.z, gl_FragCoord.y * view.size.w, float(mirror));
    float eye = length(view.camera.xyz - p);
    float shown;
    float endless = view.camera.w > 0.5 ? 1e4 * eye : 1e4;
    if (dot(n, plane.xyz) < 0.999999) {
        // a wave turns the ray: to where it meets what the flat mirror shows here
        float way = planar_way(at, 0.0, p, shown);
        vec3 r = reflect(-v, n);
        r = normalize(r + plane.xyz * max(0.02 - dot(r, plane.xyz), 0.0));
        vec3 q = p + r * (way < 0.0 ? endless : way);
        q -= 2.0 * (dot(plane.xyz, q) + plane.w) * plane.xyz;
        vec4 clip = view.clip_from_origin * vec4(q, 1.0);
        if (clip.w > 0.0) at.xy = 0.5 - 0.5 * clip.xy / clip.w;
    }
    float level = 0.0;
    float rough = max(roughness - MIN_ROUGHNESS, 0.0) / (1.0 - MIN_ROUGHNESS);
    if (rough > 0.0) {
        // as wide as the lobe is where the bodies are that it meets: how far these are is looked up as widely as it could
        // be at all, and once more where that shows any
        float spread = PLANAR_SPREAD * rough * rough;
        float way = planar_way(at, planar_level(2.0 * spread, endless, eye), p, shown);
        if (way < 0.0) return vec4(radiance, part);
        float again = planar_way(at, planar_level(spread, way, eye), p, shown);
        if (again >= 0.0) way = mix(way, again, sat(2.0 * shown));
        level = planar_level(spread, way, eye);
    }
    vec4 seen = planar_taps(at, level);
    return vec4(seen.rgb + (1.0 - sat(seen.a)) * radiance, part);
}
