// Software rasterisers look up all four pixels of a quad in one mip, even where each asks for its own. So what depends on
// the very mip asks for one alike.

// The least value in the quad; invocations outside of the triangle, whose materials may be zeros, have no say.
float least_of_quad(float value)
{
    const float NONE = 1e6;
    float least = gl_HelperInvocation ? NONE : value;
    vec2 side = 1.0 - 2.0 * mod(floor(gl_FragCoord.xy), 2.0);
    least = min(least, least + dFdxFine(least) * side.x);
    least = min(least, least + dFdyFine(least) * side.y);
    return least < 0.5 * NONE ? least : value;
}
