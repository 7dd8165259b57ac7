"""Builders of diagnostics, one module a phase."""
