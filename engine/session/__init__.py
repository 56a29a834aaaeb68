"""The conversation with one robot: its state machine, its turns, and what they do."""
