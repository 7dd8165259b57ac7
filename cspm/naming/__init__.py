"""What each name of a script stands for: scopes, modules, symbols."""
