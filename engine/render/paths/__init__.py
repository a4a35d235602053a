"""Render paths: which passes, in which order, make a frame."""
