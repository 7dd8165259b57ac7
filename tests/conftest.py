"""What holds for all tests."""

from __future__ import annotations

import gc
import os

import pytest
from hypothesis import HealthCheck, settings

from tests.examples import ANEW, USUAL, examples

# These scripts are material for the tests; many of them are wrong on purpose.
collect_ignore_glob = ["cases/*.csp", "corpus/*", "cspcheck/failing/*"]

# Programs that tests run keep their bytecode like installed ones do: without it each of them compiles the whole package
# again, and the test command takes half as long again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# So many modules and syntax trees are in memory that looking through them for garbage takes a sixth of the tests' time.
gc.set_threshold(200_000, 20, 20)


@pytest.fixture(scope="module", autouse=True)
def _what_is_there_stays() -> None:
    """Whatever outlives the tests of a file is not looked through for garbage again by those of the next."""
    gc.collect()
    gc.freeze()


# A loaded machine is no reason for a test to fail.
# The same examples every time, so that a change fails for what it changes.
# CSPCHECK_EXAMPLES raises the number of examples of every property, and looks for new ones.
settings.register_profile(
    "default",
    deadline=None,
    derandomize=not ANEW,
    max_examples=examples(USUAL),
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("default")
