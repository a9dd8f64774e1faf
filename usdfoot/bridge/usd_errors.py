"""What USD says of what it cannot do."""

from __future__ import annotations

from pxr import Tf

__all__ = ["usd_reason"]


def usd_reason(error: Tf.ErrorException) -> str:
    """USD's own words, of the first of its errors: the last says only that there were some."""
    try:
        return str(getattr(error.args[0], "commentary", error)).strip()
    except UnicodeDecodeError:  # it quotes the file
        return "it holds text that is not UTF-8"
