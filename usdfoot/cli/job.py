"""usdfoot job: a render farm's job that animates a scene."""

from __future__ import annotations

import argparse
import shlex

from usdfoot.cli import animate
from usdfoot.cli.batch_flags import limits_of

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "job"
HELP = "print a render farm's job that animates a scene"
DESCRIPTION = "Prints an Open Job Description template whose tasks animate a scene's agents chunk by chunk."
EPILOG = """\
example:
  usdfoot job city.usd -o build/city > job.yaml
  usdfoot job city.usd -o build/city --with="--chunk-size 250 --root-weight 0.5" > job.yaml
  openjd run job.yaml --step Crowd --run-dependencies

exit codes: 0 printed, 2 bad arguments

in Python:
  from usdfoot.batch.job import job_template
  print(job_template("city.usd", "build/city", chunks=4))
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("scene", metavar="SCENE", help="USD file with characters, clips and footstep plans")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="folder for crowd.usd and its layers")
    parser.add_argument(
        "--with",
        dest="options",
        metavar="OPTIONS",
        type=shlex.split,
        default=[],
        help="options of animate for all tasks, quoted: --with='--chunk-size 250'",
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the job."""
    from usdfoot.batch.job import job_template
    from usdfoot.errors import UsdfootError
    from usdfoot.pipeline.animate import count_chunks

    parser = argparse.ArgumentParser(prog="usdfoot animate")
    animate.add_arguments(parser)
    parsed = parser.parse_args([arguments.scene, "-o", arguments.output, *arguments.options])
    own = {
        "--chunk": parsed.chunk is not None,
        "--scheduler": parsed.scheduler is not None,
        "-o": parsed.output != arguments.output,
    }
    if any(own.values()):
        named = [flag for flag, is_given in own.items() if is_given]
        raise UsdfootError("--with", "says what the job itself says", "leave it out", named)
    chunks = count_chunks(
        arguments.scene,
        agents=parsed.agents,
        frames=parsed.frames,
        chunk_size=parsed.chunk_size,
        limits=limits_of(parsed),
        motion=parsed.motion,
    )
    print(job_template(arguments.scene, arguments.output, chunks=chunks, options=arguments.options), end="")
    return 0
