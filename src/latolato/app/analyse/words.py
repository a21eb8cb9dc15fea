"""Labels of options that several analyses have."""

# Others are quantities, whose names their registry knows, or belong to one analysis, whose
# `Question` has their labels.
OPTION_WORDS = {
    "angle_tolerance": "Two samples are the same within",
    "direction": "Which way it is followed",
    "drive_amplitude": "Amplitude of the drive",
    "duration": "How long each run lasts",
    "frequency_ratio": "Drive speed, ω/ω₀",
    "high": "To",
    "largest_amplitude_ratio": "Search up to the amplitude A₀/l",
    "longest": "Longest repetition to look for, in shakes",
    "low": "From",
    "method": "Method of calculation",
    "noise_seed": "Seed of the random numbers",
    "noise_strength": "Strength of the random kicks",
    "order": "Number of the tongue (1 at ω = 2ω₀)",
    "parameter": "What is changed",
    "period": "Repeats after how many shakes",
    "periods": "Shakes that are watched",
    "points": "How many values",
    "position": "Position of the ball",
    "push": "What the push gives",
    "threshold_angle": "Angle that counts",
    "trajectories": "How many repetitions",
    "transient": "Time to leave out at the beginning",
    "transient_periods": "Shakes to leave out at the beginning",
}
