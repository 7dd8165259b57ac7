"""Classes as processes: the meaning of CSP-OZ in terms of CSP."""
