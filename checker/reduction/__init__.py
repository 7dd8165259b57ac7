"""Smaller machines with the same behaviour: partition refinement and the compressions."""
