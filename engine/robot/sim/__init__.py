"""The simulated robot: a scene, a physics process, and the handle the engine holds."""
