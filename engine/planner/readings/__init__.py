"""Other ways to say the same: each reading is a request in plainer words."""
