"""Scenarios: what a run or a sweep is made of, as people write it, with units.

Imports everything up to sweeps and analyses.
"""
