"""The tree of a script: what every node is, and the forms themselves."""
