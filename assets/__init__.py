"""Package data: models manifest, scenes, phrases, sounds and demo speech. Holds no code to run."""
