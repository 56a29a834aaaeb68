"""The motor board of the Rosmaster robots, over a serial line."""
