"""From the tree of Object-Z paragraphs to text, LaTeX and plain CSPm."""
