"""From text to the tree: tokens, the grammar's table, the machine that runs it, and what it says of mistakes."""
