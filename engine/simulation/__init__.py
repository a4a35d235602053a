"""Simulated surfaces and volumes: water, fluids. Each owns its parameters, its state, a numpy reference that is the
truth for its tests, and the compute passes that do the same on the GPU. May import math, scene, framegraph, gpu.

    parameters, dt ─> step (compute passes | numpy reference) ─> state (textures, buffers) ─> passes of engine.render
"""
