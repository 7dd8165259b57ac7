"""From the end of a search to a counterexample that tells what each component did."""
