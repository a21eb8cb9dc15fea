"""Pages on one result that stand alone: what was found, how well, and what deserves a look."""
