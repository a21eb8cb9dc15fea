"""From video to physics: track tables, imports, fits, trials and comparison."""
