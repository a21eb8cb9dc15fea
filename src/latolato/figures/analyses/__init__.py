"""What people see of analyses: a module each, with the picture ``draw`` and words, ``QUESTION``."""
