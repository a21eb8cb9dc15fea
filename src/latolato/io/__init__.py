"""Files of results, and how far work is.

Imports everything up to sweeps.
"""
