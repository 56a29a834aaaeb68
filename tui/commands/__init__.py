"""One file for each command of sayso."""
