// Where the surface of a pixel is, from its depth. One function for all paths, so that their pictures have equal bits.

// `pixel`: framebuffer coordinates of its middle (gl_FragCoord.xy); depth in (0, 1], reversed. Relative to the origin.
vec3 position_from_depth(vec2 pixel, float depth)
{
    precise vec2 ndc = vec2(pixel.x * (2.0 * view.size.z) - 1.0, 1.0 - pixel.y * (2.0 * view.size.w));
    precise vec3 p;
    if (view.camera.w > 0.5) {
        // depth is near / distance
        precise vec3 ray = view.place_z.xyz + ndc.x * view.place_x.xyz + ndc.y * view.place_y.xyz;
        p = view.place_base.xyz + ray * (view.place_base.w / depth);
    } else {
        p = view.place_base.xyz + ndc.x * view.place_x.xyz + ndc.y * view.place_y.xyz + (1.0 - depth) * view.place_z.xyz;
    }
    return p;
}

// Distance along the view's axis, metres.
float view_depth(vec3 p)
{
    return -(view.view_from_origin[0].z * p.x + view.view_from_origin[1].z * p.y + view.view_from_origin[2].z * p.z
             + view.view_from_origin[3].z);
}

// Pixels that a metre across the view covers at distance d along its axis.
float pixels_per_metre(float d)
{
    float half_height = length(view.place_y.xyz) * (view.camera.w > 0.5 ? max(d, 1e-30) : 1.0);
    return 0.5 * view.size.y / half_height;
}
