-- What operators are: by recursion, or as the least of something.

lemma filter_of_empty[X] : forall s : seq X; a : power X @ s = <> => s filter a = <>
lemma filter_of_item[X] : forall x : X; a : power X @ <x> filter a = (if x in a then <x> else <>)
lemma filter_of_concatenation[X] : forall s, t : seq X; a : power X @ (s ^ t) filter a = (s filter a) ^ (t filter a)
lemma squash_of_empty[X] : forall f : int -||-> X @ f = {} => squash f = <>
lemma squash_of_greater[X] : forall f : int -||-> X; n : int; x : X | (forall m : dom f @ m < n) @
  squash (f (+) {n |-> x}) = squash f ^ <x>
lemma closure_contains[X] : forall r : X <-> X @ r subseteq r^+
lemma closure_is_transitive[X] : forall r : X <-> X; x, y, z : X | (x, y) in r^+ and (y, z) in r^+ @ (x, z) in r^+
lemma closure_is_least[X] : forall r, q : X <-> X | r subseteq q and q comp q subseteq q @ r^+ subseteq q

-- Cardinality.

lemma card_of_union[X] : forall a, b : finset X @ #(a union b) = #a + #b - #(a inter b) by induction on a
lemma card_of_difference[X] : forall a, b : finset X @ #(a \ b) = #a - #(a inter b) by induction on a
lemma card_of_subset[X] : forall a, b : finset X | a subseteq b @ #a <= #b
lemma card_of_equal_subset[X] : forall a, b : finset X | a subseteq b and #a = #b @ a = b
lemma card_of_domain[X, Y] : forall f : X -||-> Y @ #(dom f) = #f

-- Restriction.

lemma card_of_range_restriction[X, Y] : forall f : X -||-> Y; b : power Y @ #(f |> b) <= #f
lemma card_of_domain_restriction[X, Y] : forall f : X -||-> Y; a : power X @ #(a <| f) <= #f
lemma card_of_removal[X, Y] : forall f : X -||-> Y; x : X | x in dom f @ #({x} </| f) = #f - 1
lemma range_of_override[X, Y] : forall f : X -|-> Y; x : X; y : Y @ ran (f (+) {x |-> y}) = ran ({x} </| f) union {y}

-- Injectivity.

lemma injective_after_new[X, Y] : forall f : X >-|-> Y; x : X; y : Y | y notin ran f @ f (+) {x |-> y} in X >-|-> Y
lemma injective_after_removal[X, Y] : forall f : X >-|-> Y; a : power X @ a </| f in X >-|-> Y

-- Closure.

lemma closure_is_monotonic[X] : forall r, q : X <-> X | r subseteq q @ r^+ subseteq q^+
  using closure_contains, closure_is_transitive, closure_is_least

-- Filters and squash.

lemma length_of_filter[X] : forall s : seq X; a : power X @ #(s filter a) <= #s
lemma length_of_squash[X] : forall f : int -||-> X @ #(squash f) = #f
