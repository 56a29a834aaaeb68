"""From what is meant to the actions that do it."""
