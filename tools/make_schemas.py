"""Regenerates schemas/generatedSchema.usda and schemas/plugInfo.json from schemas/schema.usda: `make schemas`."""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

SCHEMAS = Path(__file__).resolve().parents[1] / "schemas"
GENERATED = ("generatedSchema.usda", "plugInfo.json")
PLACEHOLDERS = {
    "@PLUG_INFO_LIBRARY_PATH@": "",
    "@PLUG_INFO_RESOURCE_PATH@": ".",
    "@PLUG_INFO_ROOT@": ".",
}
"""What a build system would fill in: a codeless plugin has no library, and its files lie beside plugInfo.json."""


def generate(folder: Path) -> None:
    """Write the generated files of the schemas into a folder.

    Args:
        folder: Existing folder; files of the same names in it are replaced.

    Raises:
        RuntimeError: usdGenSchema refuses schema.usda; its output is the message.
    """
    with tempfile.TemporaryDirectory() as scratch:
        command = [sys.executable, "-m", "pxr.Usd.usdGenSchema", str(SCHEMAS / "schema.usda"), scratch]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode != 0:
            raise RuntimeError(f"usdGenSchema: {run.stdout}{run.stderr}")
        for name in GENERATED:
            text = (Path(scratch) / name).read_text(encoding="utf-8")
            for placeholder, value in PLACEHOLDERS.items():
                text = text.replace(placeholder, value)
            lines = [line.rstrip() for line in text.splitlines()]
            (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


def main(argv: list[str] | None = None) -> int:
    """Parse the arguments and write the files.

    Returns:
        The exit code, 0.
    """
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=SCHEMAS, help="folder to write to (default: schemas/)")
    generate(parser.parse_args(argv).output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
