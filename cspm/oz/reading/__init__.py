"""From text or LaTeX to the tree of Object-Z paragraphs."""
