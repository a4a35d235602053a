// Views of one thing about a surface; numbers as in engine/render/settings.py. Included by the surface's fragment shader.
#include "lib/math.glsl"

#define VIEW_LIGHTING (DEBUG_VIEW == 13)
#define VIEW_DEPTH (DEBUG_VIEW == 14)
#define VIEW_OVERDRAW (DEBUG_VIEW == 15)
#define VIEW_WIREFRAME (DEBUG_VIEW == 16)
#define VIEW_TEXEL_DENSITY (DEBUG_VIEW == 17)
#define VIEW_UV_CHECKER (DEBUG_VIEW == 18)
#define VIEW_OF_SURFACE (DEBUG_VIEW >= 14 && DEBUG_VIEW <= 18)

// These write a quantity, which the last pass colours (passes/tone_map.frag, engine/render/legends.py).
#define VIEW_OF_VALUE (VIEW_DEPTH || VIEW_OVERDRAW || VIEW_TEXEL_DENSITY || VIEW_SHADOW_TEXELS)

#if VIEW_DEPTH
#include "lib/position.glsl"
#endif

// Texels a metre, of a texture of `size` texels laid by `uv` over the points `p`; and how light to draw it: cells of 16
// texels, light and dim.
vec2 texel_density_view(vec2 uv, vec2 size, vec3 p)
{
    vec2 du = dFdx(uv) * size;
    vec2 dv = dFdy(uv) * size;
    vec3 facet = cross(dFdx(p), dFdy(p));
    float texels = abs(du.x * dv.y - du.y * dv.x);
    float area = length(facet);
    float density = sqrt(texels / max(area, 1e-20));
    vec2 cell = floor(uv * size / 16.0);
    float checked = mod(cell.x + cell.y, 2.0);
    return vec2(clamp(density, 1e-3, 32000.0), 0.75 + 0.25 * checked);
}

// Eight cells each way over one turn of uv; red grows with u, green with v (down), so that mirrored and turned parts show;
// the cell at the origin is marked white.
vec3 uv_checker_view(vec2 uv)
{
    vec2 turn = fract(uv);
    vec2 cell = floor(turn * 8.0);
    float checked = mod(cell.x + cell.y, 2.0);
    vec3 tint = vec3(0.15 + 0.8 * turn.x, 0.15 + 0.8 * turn.y, 0.35);
    if (cell.x + cell.y < 0.5) return vec3(1.0);
    return tint * (checked > 0.5 ? 1.0 : 0.45);
}
