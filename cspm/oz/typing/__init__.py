"""What the paragraphs of a script mean: types, inheritance, interfaces."""
