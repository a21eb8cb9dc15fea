"""The command line, a module for each command.

Imports everything; nothing but the entry of the program imports it.
"""
