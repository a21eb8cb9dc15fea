"""Fits of track tables: free decay, drive, impacts and whole models, each in its own module."""
