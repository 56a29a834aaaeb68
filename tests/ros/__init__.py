"""Tests of the doors to a ROS 2 graph, against real peers."""
