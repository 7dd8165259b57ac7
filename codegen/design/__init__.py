"""From a script to the design of a program: which tasks there are, on which channels they meet, what each does."""
