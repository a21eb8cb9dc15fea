"""Pictures of runs, maps, analyses, fits and comparisons."""
