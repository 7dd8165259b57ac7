"""Proof: the predicates of classes as formulas, and what is to be shown about them."""
