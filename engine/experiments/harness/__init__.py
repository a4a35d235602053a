"""What experiments stand on: their declaration, the context they run in, the sweep, truths, and shaders over arrays."""
