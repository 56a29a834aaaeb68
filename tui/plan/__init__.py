"""The map of the house in characters."""
