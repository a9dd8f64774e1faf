"""Messages on stderr."""

import logging

from usdfoot.cli.console import logging_on_stderr


def test_what_several_readers_doubt_is_said_once(capsys):
    logger = logging.getLogger("usdfoot.readers.skeleton")
    for _ in range(2):
        with logging_on_stderr(quiet=False, verbose=False):
            for name in ("/A", "/A", "/B"):
                logger.warning("%s: no rest pose", name)
    lines = [f"usdfoot: WARNING: /{name}: no rest pose" for name in "AB"]
    assert capsys.readouterr().err.splitlines() == lines * 2
