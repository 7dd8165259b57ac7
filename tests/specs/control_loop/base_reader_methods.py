"""What BaseReader does by itself: it waits for a datagram of the base station and decodes it."""

from __future__ import annotations

import re

from .base_reader import BaseReaderData, BaseReaderMethods
from .link import world

MESSAGE = re.compile(r"\$(?:[xyzt]-?[0-9]+\.[0-9]{2})+\$")
FIELD = re.compile(r"([xyzt])(-?[0-9]+)\.([0-9]{2})")


def decode(text: str) -> tuple[bool, int]:
    """Whether a message is well formed, and its speed ahead in hundredths; as in messages.csp."""
    if not MESSAGE.fullmatch(text):
        return False, 0
    values = {name: int(whole + part) for name, whole, part in FIELD.findall(text)}
    if len(values) < len(FIELD.findall(text)) or any(abs(value) > 100 for value in values.values()):
        return False, 0
    return True, values.get("x", 0)


class Methods(BaseReaderMethods):
    """The methods of BaseReader."""

    def get_message(self, data: BaseReaderData) -> tuple[bool, int]:
        """Wait for a message."""
        text = world.receive()
        return (False, 0) if text is None else decode(text)
