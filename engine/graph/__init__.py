"""sayso as a part of a ROS 2 graph, whatever its robot is: what it hears there, what it tells, what it does for peers.

Peers are not trusted: what cannot be read is refused with a line in the log, and nothing that they send raises.
"""
