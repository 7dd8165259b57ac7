"""Components and the rules by which they step together, and the compiler from terms to them."""
