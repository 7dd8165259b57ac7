"""The verdicts: process terms to machines, searches and behaviours."""
