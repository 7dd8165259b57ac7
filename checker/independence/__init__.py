"""Which verdicts hold for every size of a type, because processes only compare its values and pass them on."""
