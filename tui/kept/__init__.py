"""What outlives a session, in files of its own."""
