"""Speech recognition: one small protocol, one file per backend."""
