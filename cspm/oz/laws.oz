lemma length_of_concatenation[X] : forall s, t : seq X @ #(s ^ t) = #s + #t
