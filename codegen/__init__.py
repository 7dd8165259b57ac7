"""The workshop: a checked design becomes runnable tasks and channels."""
