"""Exact solutions and tools that read more out of a motion than its samples."""
