"""Synthetic videos: a scene, a camera, and a run filmed by it with the true table."""
