// The view block is generated (engine/render/view_block.py). Positions are relative to the view's origin.

// Towards the camera: from a point in perspective, one direction for all in an orthographic view.
vec3 view_vector(vec3 p)
{
    return view.camera.w > 0.5 ? view.camera.xyz - p : view.camera.xyz;
}
