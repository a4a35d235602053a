// pixels; what was not in front of the camera, or farther off than any picture is wide, is outside of every picture
const float NOWHERE = 30000.0;

// From where something is (ndc, without jitter) and where it was (clip space): pixels to the right and down.
vec2 pixels_moved(vec2 ndc, vec4 before)
{
    if (!(before.w > 0.0)) return vec2(NOWHERE);
    vec2 moved = (ndc - before.xy / before.w) * vec2(0.5, -0.5) * view.size.xy;
    return all(lessThan(abs(moved), vec2(NOWHERE))) ? moved : vec2(NOWHERE);
}
