"""Skills: everything the robot can be asked to do, as typed functions in a registry."""
