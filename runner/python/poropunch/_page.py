"""Pages in notebooks."""

from __future__ import annotations

import html

#: Height of a page in a notebook (pixels); it scrolls.
_HEIGHT = 720


def framed(page: str) -> str:
    """A page in a frame of its own, whose styles and scripts leave the notebook alone."""
    return f'<iframe srcdoc="{html.escape(page, quote=True)}" style="width: 100%; height: {_HEIGHT}px; border: 0"></iframe>'
