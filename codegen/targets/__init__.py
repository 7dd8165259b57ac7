"""What travels with programs for other languages: the sources of their runtimes, one folder a target."""
