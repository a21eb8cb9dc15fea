"""What people see of analyses: words in a module each, and a picture, often from `drawings`."""
