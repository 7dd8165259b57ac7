"""The explorer: a script in the browser, behind ``cspcheck explore``."""
