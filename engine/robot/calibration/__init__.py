"""What is found out about one robot by measuring it: arithmetic and geometry, with neither terminal nor robot."""
