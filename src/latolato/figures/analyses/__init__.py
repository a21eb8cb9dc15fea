"""What people see of analyses: a module each.

``draw(dataset)`` returns its picture, by default that of `drawings`. `READING` says how to read the
picture. `FIRST` names the options that a page shows at once, with the text that each begins with:
empty for the usual value, ``{ratios}`` and ``{amplitudes}`` for ranges about those of the drive.
"""
