"""What editors ask about a script: the language server behind ``cspcheck lsp``."""
