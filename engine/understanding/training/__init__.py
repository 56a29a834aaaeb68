"""Training of the learned reader. Needs the extra ``train`` (torch); nothing here is imported to run it."""
