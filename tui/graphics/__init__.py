"""Pictures as pixels, on terminals that can show them: which ones can, and what they are sent."""
