"""What is in a folder's files, to be compared."""

import hashlib
from pathlib import Path


def digests(folder: Path) -> dict[str, str]:
    """Content of every file of a folder, by path."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
