"""One question of an assertion each: what is explored for it, and what the outcome means."""
