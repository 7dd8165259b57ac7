"""From a design to files: the text of a program, and what becomes of files that are there already."""
