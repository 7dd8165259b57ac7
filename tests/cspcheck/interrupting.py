"""Programs that are to be interrupted."""

from __future__ import annotations

import signal
from functools import partial

LISTENING = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
"""As ``preexec_fn``: who was started in the background ignores the signal, and so would the program."""
