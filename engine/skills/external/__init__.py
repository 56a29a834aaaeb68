"""Skills that are programs of their own, in any language: declared in ``skills.yaml``, hosted in a process tree."""
