"""Configuration: what a user edits, and the one place that reads it."""
