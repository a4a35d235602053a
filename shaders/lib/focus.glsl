// Radii are kept in texels of half size and raised by the widest, so that none is below 0.
float stored_radius(float pixels) { return 0.5 * (pixels + dof.widest); }
float kept_radius(float stored) { return stored - 0.5 * dof.widest; }

#ifdef FOCUS
// Radius in pixels of the disc that a point at this device depth is spread over; below 0 behind what is in focus.
float disc_radius(float depth)
{
    float focus = dof.focus;
    if (focus < 0.0) focus = depth_at(ivec2(view.size.xy * 0.5));
    return clamp(dof.scale * (depth - focus), -dof.widest, dof.widest);
}
#endif
