"""From a network to words and masks: how states are laid out, and which rules can fire."""
