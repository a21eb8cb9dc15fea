"""From pixels to angles: lens, hinge, gravity's direction, honest deviations."""
