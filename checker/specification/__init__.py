"""Normal forms: what a process may do and refuse after each trace."""
