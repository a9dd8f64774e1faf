"""Job: an Open Job Description template that animates a crowd's chunks as tasks of a render farm."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Sequence

from usdfoot.errors import UsdfootError
from usdfoot.writers.paths import folder_path

__all__ = ["job_template"]

LONGEST_NAME = 100
"""Characters of a scene's name that a job's has, which must not be longer than 128."""


def job_template(
    scene: str | os.PathLike[str], folder: str | os.PathLike[str], *, chunks: int, options: Sequence[str] = ()
) -> str:
    """A job template (specification 2023-09, YAML) of two steps: every chunk a task, then the crowd around them.

    The paths are parameters of type STRING: those of type PATH may not have absolute paths as defaults, and relative
    ones would count from wherever the template is put.

    Args:
        scene: The scene's file, the default of the job's parameter Scene.
        folder: The crowd's folder, the default of the job's parameter Output.
        chunks: Number of chunks.
        options: Of `usdfoot animate`, the same for every task.

    Raises:
        OutputError: If no folder is named.
        UsdfootError: If options have what a template takes for a variable.
    """
    variables = [option for option in options if "{{" in option]
    if variables:
        raise UsdfootError("options", "have {{ in them, where a job puts a variable", "write them otherwise", variables)
    folder_path(folder)  # as given it may be a link, which leads elsewhere on the farm's machines
    common = ["animate", "{{Param.Scene}}", "-o", "{{Param.Output}}", *options]
    chunk = [*common, "--chunk", "{{Task.Param.Chunk}}"]
    return f"""\
specificationVersion: jobtemplate-2023-09
name: {_quoted(f"usdfoot {_plain(os.path.basename(scene))}")}
parameterDefinitions:
  - name: Scene
    type: STRING
    default: {_quoted(os.path.abspath(scene))}
  - name: Output
    type: STRING
    default: {_quoted(os.path.abspath(folder))}
steps:
  - name: Chunks
    parameterSpace:
      taskParameterDefinitions:
        - name: Chunk
          type: INT
          range: "0-{chunks - 1}"
    script:
      actions:
        onRun:
          command: usdfoot
          args: {_quoted(chunk)}
  - name: Crowd
    dependencies:
      - dependsOn: Chunks
    script:
      actions:
        onRun:
          command: usdfoot
          args: {_quoted([*common, "--workers", "1"])}
"""


def _plain(name: str) -> str:
    """A name as a job's may be: short, without what it takes for a variable and without line breaks."""
    return re.sub(r"[^\w .-]", "_", name)[:LONGEST_NAME]


def _quoted(value: object) -> str:
    """The value as JSON, which is YAML too."""
    return json.dumps(value, ensure_ascii=False)
