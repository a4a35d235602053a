"""What experiments stand on: declarations, the context they run in, the sweep, scenes, truths, shaders over arrays."""
