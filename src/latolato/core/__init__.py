"""What everything builds on: quantities, registries, errors, formulas, the cache.

Imports nothing of the package.
"""
