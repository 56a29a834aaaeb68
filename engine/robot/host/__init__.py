"""The host: the process that owns a robot. Its rules hold for every body that is put below it."""
