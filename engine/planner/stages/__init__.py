"""Large models: what they are told, what they answer, and what is set right in it."""
