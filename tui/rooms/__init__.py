"""The rooms of the console: one part of what it does each, on one stage."""
