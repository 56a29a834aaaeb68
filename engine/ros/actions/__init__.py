"""Actions for doors whose protocol knows only topics and services."""
