"""The laws of driven and colliding pendula as plain scalar formulas."""
