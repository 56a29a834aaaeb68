"""Hearing: where sound comes from, whether somebody speaks, and when they have finished."""
