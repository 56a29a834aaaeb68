"""What a request means: the typed meaning, and the readers that find it."""
