"""What a request leaves open, found in its words before a model is asked, which would fill the gap with a guess."""
