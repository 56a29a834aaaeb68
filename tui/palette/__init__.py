"""The command palette: everything that the console and the robot can do, found by typing a part of it."""
