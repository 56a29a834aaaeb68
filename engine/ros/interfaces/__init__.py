"""The types of messages, services and actions, and how their messages are written in bytes."""
