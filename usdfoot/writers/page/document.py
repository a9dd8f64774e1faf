"""The page itself: template, style, scripts and data in one file that asks nothing of any network."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import os
import re
from importlib.resources import files
from pathlib import Path
from typing import Any

from usdfoot.errors import OutputError
from usdfoot.writers.page.arrays import crowd_arrays, crowd_header
from usdfoot.writers.page.block import encode_block
from usdfoot.writers.page.pictures import CrowdPicture
from usdfoot.writers.page.three import three_source

__all__ = ["SCRIPTS", "check_page", "page_text", "write_document"]

SUFFIXES = (".html", ".htm")

SCRIPTS = (
    "data",
    "crowd",
    "state",
    "dom",
    "copies",
    "bones",
    "prints",
    "ground",
    "view",
    "player",
    "chart",
    "plan",
    "timing",
    "heights",
    "weights",
    "histograms",
    "rows",
    "agents",
    "steps",
    "summary",
    "main",
)
"""Files of assets/ in the order they run."""


def write_document(path: Path, crowd: CrowdPicture) -> None:
    """Write the page, whole or not at all.

    Raises:
        OutputError: If it cannot be written.
        UsdfootError: If three.js is not installed.
    """
    check_page(path)
    text = page_text(crowd)
    waiting = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        waiting.write_text(text, encoding="utf-8", newline="\n")
        os.replace(waiting, path)
    except OSError as error:
        raise OutputError(path, "cannot be written", str(error)) from error


def check_page(path: Path) -> None:
    """Nothing, if a page may be written there; a crowd's own files are none.

    Raises:
        OutputError: If the name does not end like a page's.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise OutputError(path, f"ends in {path.suffix or 'no suffix'}", f"name a page that ends in {SUFFIXES[0]}")


def page_text(crowd: CrowdPicture) -> str:
    """The page. Same picture, same text.

    Whatever comes from the scene is data: it stands in blocks that browsers do not run, with every `<` escaped, and
    scripts other than these two, known by their hashes, do not run either.
    """
    directory, block = encode_block(crowd_arrays(crowd))
    style = _asset("page.css")
    three = three_source()
    script = "\n".join(_asset(f"{name}.js") for name in SCRIPTS)
    parts = {
        "title": html.escape(crowd.title),
        "policy": (
            f"default-src 'none'; img-src data:; style-src {_hash(style)}; script-src {_hash(three)} {_hash(script)}"
        ),
        "style": style,
        "header": _json({**crowd_header(crowd), "arrays": directory}),
        "block": block,
        "three": three,
        "script": script,
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], _asset("page.html"))


def _asset(name: str) -> str:
    return (files("usdfoot.writers.page") / "assets" / name).read_text(encoding="utf-8")


def _json(value: Any) -> str:
    """JSON that stays data wherever it stands in a page."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"), ensure_ascii=True)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _hash(text: str) -> str:
    """How a content security policy names a script or style."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"
