"""The language: text to syntax, names, types, values and process terms."""
