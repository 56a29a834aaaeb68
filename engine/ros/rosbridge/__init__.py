"""The door by rosbridge."""
