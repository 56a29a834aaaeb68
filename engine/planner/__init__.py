"""Planning: from what was said to a plan of actions."""
