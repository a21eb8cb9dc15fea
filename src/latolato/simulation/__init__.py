"""One run: how it begins, how it is computed, and what it yields.

Imports the core, physics, observables and numerics.
"""
