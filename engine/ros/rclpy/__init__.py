"""The door by rclpy, where sayso runs inside an installation of ROS 2."""
