"""Messages on stderr."""

import logging

from usdfoot.cli.console import logging_on_stderr


def test_what_several_readers_doubt_is_said_once(capsys):
    logger = logging.getLogger("usdfoot.readers.skeleton")
    for _ in range(2):
        with logging_on_stderr(quiet=False, verbose=False):
            for name in ("/A", "/A", "/B"):
                logger.warning("%s: no rest pose", name)
    assert (
        capsys.readouterr().err.splitlines()
        == ["usdfoot: WARNING: /A: no rest pose", "usdfoot: WARNING: /B: no rest pose"] * 2
    )
