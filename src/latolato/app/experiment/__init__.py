"""The view Experiment: videos that pages upload, their tracking and their fits."""
