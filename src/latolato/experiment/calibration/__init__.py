"""From pixels to angles: lens, hinge, direction of gravity, realistic deviations."""
