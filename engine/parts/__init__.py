"""What an engine is made of: each part is loaded in the background, kept, and looked for when it is lost."""
