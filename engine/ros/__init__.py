"""Doors to a ROS 2 graph, without ROS on this machine, and the messages that pass through them."""
