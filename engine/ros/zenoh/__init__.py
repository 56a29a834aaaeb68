"""The door by zenoh, in the wire format of rmw_zenoh."""
