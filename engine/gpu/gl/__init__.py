"""The OpenGL backend: GL 4.5 core, or 4.3 with direct state access and clip control. Imported only by open_device.

    context    makes the context (glcontext) or finds the window's; its loader gives functions.Functions, by ctypes
    device     GlDevice: creates everything below, owns caches and the queue of objects to free
    state      StateCache: what is bound now, so that a pass only issues what differs
    buffer, texture, sampler, shader, pipeline, vertex_array, framebuffer     one kind of object each
    program_store     programs by their text: begun ahead, finished, or taken from the program cache
    render_pass, compute_pass     the encoders: they call GL at once
    capabilities, timestamps      what the device can do; GPU time

Clip control is UPPER_LEFT and ZERO_TO_ONE, so row 0 of every framebuffer and texture is the top row and depth is
reversed-z without loss. FRAMEBUFFER_SRGB stays off: shaders encode.
"""
