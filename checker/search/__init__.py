"""Breadth-first search over packed states: levels, threads, pairs, paths, limits."""
