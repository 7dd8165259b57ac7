"""Processes of classes with unbounded data, decided for all values: what control does is finite, the rest is proved."""
