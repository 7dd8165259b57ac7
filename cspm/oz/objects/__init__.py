"""The types of plain Object-Z with objects as references, whatever can be run of it."""
