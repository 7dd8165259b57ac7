"""``--cluster``: what the processes do that ``mpiexec`` has started."""

from __future__ import annotations

import signal
import sys
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
    except BaseException as error:
        # Whoever waits for this process would wait for ever.
        _tell(error, f"searching as process {cluster.ranks.rank + 1} of {cluster.ranks.size}")
        cluster.ranks.abort()
    yield False


def _tell(error: BaseException, doing: str) -> None:
    from cspcheck.cli.streams import Remarks
    from cspcheck.failure import InternalErrors
    from cspcheck.messages import out_of_memory
    from cspcheck.report.diagnostics import render_diagnostics
    from cspcheck.report.style import style_for

    if isinstance(error, MemoryError):
        diagnostic = out_of_memory().with_notes(doing, "`--max-memory` is for each process; start more of them")
    else:
        diagnostic = InternalErrors(sys.argv[1:]).report(error, doing)
    Remarks().write(render_diagnostics([diagnostic], style_for(sys.stderr)))
