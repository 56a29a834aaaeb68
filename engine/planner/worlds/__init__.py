"""What can be named: the configured house, and worlds of others."""
