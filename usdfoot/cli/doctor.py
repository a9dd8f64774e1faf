"""usdfoot doctor: what usdfoot runs on here."""

from __future__ import annotations

import argparse
import json

from usdfoot.cli.console import results_console
from usdfoot.cli.tables import symptom_table

__all__ = ["DESCRIPTION", "EPILOG", "HELP", "NAME", "add_arguments", "run"]

NAME = "doctor"
HELP = "say what usdfoot runs on here, and what is missing or broken"
DESCRIPTION = (
    "Prints versions, which USD is in use and where it comes from, Warp's devices, whether USD knows usdfoot's "
    "plugins, and which optional extras are installed."
)
EPILOG = """\
example:
  usdfoot doctor
  usdfoot doctor --json > doctor.json

exit codes: 0 all that is needed works, 1 something needed is broken

in Python:
  from usdfoot.pipeline.doctor import examine
  for symptom in examine().symptoms: print(symptom.name, symptom.state, symptom.told)
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("--json", action="store_true", help="print JSON instead of a table")


def run(arguments: argparse.Namespace) -> int:
    """Examine; 0 = healthy."""
    from usdfoot.pipeline.doctor import examine

    diagnosis = examine()
    if arguments.json:
        print(json.dumps(diagnosis.to_json(), indent=1))
    else:
        results_console().print(symptom_table(diagnosis.symptoms))
    return 0 if diagnosis.healthy else 1
