"""Sets as ascending arrays, held against what numpy has for them."""

from __future__ import annotations

import numpy as np
from hypothesis import given, strategies as st

from cspcheck.checker.arrays import among, distinct

INTEGERS = st.integers(-3, 12) | st.integers(-(2**63), 2**63 - 1)
VALUES = st.lists(INTEGERS).map(lambda some: np.array(some, dtype=np.int64))


@given(VALUES)
def test_distinct_values(values: np.ndarray) -> None:
    kept = values.copy()
    assert distinct(values).tolist() == np.unique(values).tolist()
    assert distinct(values.astype(np.int32)).dtype == np.int32
    assert not np.shares_memory(distinct(values), values)
    assert (values == kept).all()


@given(VALUES, VALUES)
def test_values_among_known_ones(values: np.ndarray, known: np.ndarray) -> None:
    assert among(values, distinct(known)).tolist() == np.isin(values, known).tolist()
