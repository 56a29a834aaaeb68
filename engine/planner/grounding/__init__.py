"""Every object, place and number of a plan has a ground: it was said, or seen, or is known, or is a convention."""
