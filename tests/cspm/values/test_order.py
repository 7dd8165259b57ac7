"""The order of all values, where it is compared by something else than the values themselves."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given, strategies as st

from cspcheck.cspm.values.order import in_order, order_key
from cspcheck.cspm.values.values import Real

NUMBERS = st.fractions() | st.integers().map(Fraction) | st.floats(allow_nan=False, allow_infinity=False).map(Fraction)
NEAR = st.tuples(NUMBERS, st.sampled_from([Fraction(0), Fraction(1, 10**40), Fraction(10) ** 400])).map(sum)


@given(st.lists(NEAR))
def test_real_numbers_are_in_the_order_of_their_sizes(numbers: list[Fraction]) -> None:
    assert [real.value for real in in_order(map(Real, numbers))] == sorted(numbers)


@given(NEAR, st.integers())
def test_real_numbers_compare_with_whole_ones(number: Fraction, whole: int) -> None:
    assert (order_key(Real(number)) < order_key(whole)) == (number < whole)


@given(NEAR, NEAR)
def test_equal_ones_have_one_hash(number: Fraction, other: Fraction) -> None:
    assert (Real(number) == Real(other)) == (number == other)
    assert hash(Real(number)) == hash(Real(Fraction(str(number))))
