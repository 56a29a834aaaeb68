"""Speech synthesis: one small protocol, one file per backend."""
