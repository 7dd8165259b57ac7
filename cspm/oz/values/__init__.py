"""Values of Object-Z expressions under a finite reading, and the search for those that fit a predicate."""
