"""From sound to words: listening, recognising ahead, overhearing."""
