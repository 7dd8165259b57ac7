"""CSP-OZ: classes that join a CSP process with an Object-Z part, beside ordinary CSPm in one script."""
