"""What people see of `swing_time`, as it would lie in `latolato/figures/analyses`."""

READING = "To the right how wide it swings, upwards how long a swing takes."
FIRST = {"largest_angle": "", "swings": "20"}
