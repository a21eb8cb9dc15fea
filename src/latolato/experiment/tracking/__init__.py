"""Finds pivot and balls in the frames of a video."""
