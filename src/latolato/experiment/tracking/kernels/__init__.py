"""The tracker's compiled inner loops."""
