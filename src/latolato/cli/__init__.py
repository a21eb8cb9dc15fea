"""The command line, a module for each command. Nothing but the entry of the program imports it."""
