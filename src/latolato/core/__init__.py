"""What everything else builds on: quantities, registries, errors, formulas, the cache folder.

Imports nothing of the package.
"""
