"""A motor board to test on, with the simulated robot behind it."""
