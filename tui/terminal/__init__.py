"""The line to the terminal: what it sends, what it bears, and what it can draw."""
