"""What sentences are made of: words, numbers and measures, in English and Chinese."""
