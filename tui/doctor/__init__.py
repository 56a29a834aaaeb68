"""What is well with this machine, and the fix for what is not."""
