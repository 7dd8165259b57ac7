"""Values of expressions, their order, comparison and text; what can go wrong in making them."""
