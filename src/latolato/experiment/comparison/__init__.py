"""Comparisons of measurement and computation: motion, trials on a map, response curves."""
