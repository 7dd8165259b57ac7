"""From the tree back to text: exactly as read, or laid out anew."""
