"""From pictures to things: what is seen, where it is on the map, and what was seen before."""
