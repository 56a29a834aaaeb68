"""How it looks: colours and contrast."""
