"""What every operator does: the operational semantics of terms, one rule an operator."""
