"""The paper that latolato began with: its figures, the evidence for its claims, and the report.

A user of the library like any other: it imports public names only, and nothing but the command
`reproduce` and the site imports it. Another paper can stand beside it as a package of the same
kind.
"""
