"""Types of expressions: what they are, when two are one, and how they are inferred."""
