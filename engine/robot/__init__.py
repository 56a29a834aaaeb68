"""Robots: the protocol that every robot speaks, its safety envelope, and the simulated one."""
