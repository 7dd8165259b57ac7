"""Text that pictures carry."""

from __future__ import annotations

import html

from cspcheck.report.style import harmless


def escape(text: str) -> str:
    """*text* as the content or an attribute of an element: no markup, and no characters that XML does not have."""
    return html.escape(harmless(text))
