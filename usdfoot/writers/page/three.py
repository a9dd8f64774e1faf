"""three.js, as a package brings it: the page's 3-D view is drawn with it."""

from __future__ import annotations

import importlib.util
from pathlib import Path

from usdfoot.errors import UsdfootError

__all__ = ["three_source"]

PACKAGE = "jupyter_threejs_sage"
BUILDS = "static/r*/three.min.js"


def three_source() -> str:
    """The text of three.js, newest revision of the package.

    Raises:
        UsdfootError: If the package is not installed or has no build of it.
    """
    found = importlib.util.find_spec(PACKAGE)
    folders = list(found.submodule_search_locations or ()) if found else []
    builds = [build for folder in folders for build in Path(folder).glob(BUILDS)]
    if not builds:
        raise UsdfootError(
            "three.js", "is not installed, so the page cannot have its 3-D view", "pip install 'usdfoot[report]'"
        )
    return max(builds, key=lambda build: int(build.parent.name[1:])).read_text(encoding="utf-8")
