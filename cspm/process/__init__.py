"""Processes as immutable terms, the events that they perform, and both as text."""
