"""One pass a file, its shader of the same name in shaders/passes. A pass sees the scene only through RenderFrame."""
