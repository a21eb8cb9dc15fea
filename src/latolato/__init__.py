"""Driven and colliding pendula: simulate, map, analyse, measure and play."""
