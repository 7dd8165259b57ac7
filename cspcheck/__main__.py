"""``python -m cspcheck`` is ``cspcheck``."""

from __future__ import annotations

import gc
import signal
import sys
from types import FrameType
from typing import NoReturn

COLLECTOR = (100_000, 20, 20)
"""How seldom the command looks for cycles: in objects, and in looks at younger ones for one at older ones."""


def main() -> NoReturn:
    """Run the command line of the process and end it.

    A signal to end is an interrupt from the first moment on, while what the command needs is still being imported.
    """
    # What a script is read into stays until the end: to look for cycles after every 700 objects is a tenth of the time
    # of a small check.
    gc.set_threshold(*COLLECTOR)
    try:
        signal.signal(signal.SIGTERM, asked_to_end)
        from cspcheck.cli import run

        code = run()
    except KeyboardInterrupt:
        code = 130
    # An interrupt that came while text was executed (as dataclasses do) is remembered by CPython although it has been
    # handled, and the process would end by the signal instead of with this code. Executing a text makes it forget.
    exec("")
    if "cspcheck.cli" in sys.modules:
        from cspcheck.cli import end

        end(code)
    sys.exit(code)


def asked_to_end(number: int, frame: FrameType | None) -> None:
    """What the signal to end does: an interrupt that says which signal it was."""
    raise KeyboardInterrupt(number)


if __name__ == "__main__":
    main()
