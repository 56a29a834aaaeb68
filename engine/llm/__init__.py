"""Large models: one protocol (``chat``), one file per kind of service."""
