"""Speech recognition: one small protocol, one file per backend, and a process of its own to run it in."""
