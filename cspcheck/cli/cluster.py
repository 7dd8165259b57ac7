"""``--cluster``: what the processes do that ``mpiexec`` has started."""

from __future__ import annotations

import signal
import traceback
from collections.abc import Iterator
from contextlib import contextmanager

import click


@contextmanager
def together() -> Iterator[bool]:
    """Take part in the searches of the first process; whether this is the first one.

    The others have nothing to do any more when the block is entered.

    Raises:
        UsageError: there is no MPI.
    """
    from cspcheck.checker.search.cluster import world

    try:
        cluster = world()
    except (ImportError, RuntimeError) as error:
        raise click.UsageError(
            f"`--cluster` needs MPI (`pip install 'cspcheck[cluster]'` and an MPI library): {error}"
        ) from None
    if cluster.ranks.rank == 0:
        try:
            yield True
        finally:
            cluster.dismiss()
        return
    for number in (signal.SIGINT, signal.SIGTERM):
        # The first process hears of it as well, and tells when there is nothing left to do.
        signal.signal(number, signal.SIG_IGN)
    try:
        cluster.serve()
    except BaseException:
        # Whoever waits for this process would wait for ever.
        traceback.print_exc()
        cluster.ranks.abort()
    yield False
