"""Elements of an XML file that know their line; documents with a DTD or entities are refused."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from usdfoot.errors import SceneError

__all__ = ["Element", "parse_xml"]


@dataclass(frozen=True, kw_only=True)
class Element:
    """One element of a file."""

    file: str
    line: int
    tag: str
    """Without its namespace."""
    children: list[Element] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """All of its own text."""
        return "".join(self.texts).strip()

    def error(self, what: str, remedy: str = "") -> SceneError:
        """An error that names the line."""
        return SceneError(f"{self.file}, line {self.line}, <{self.tag}>", what, remedy)

    def all(self, tag: str) -> Iterator[Element]:
        """Children of that tag."""
        return (child for child in self.children if child.tag == tag)

    def find(self, tag: str) -> Element | None:
        """The first child of that tag."""
        return next(self.all(tag), None)

    def need(self, tag: str) -> Element:
        """The first child of that tag.

        Raises:
            SceneError: If there is none.
        """
        child = self.find(tag)
        if child is None:
            raise self.error(f"has no <{tag}>", f"give it one, like <{tag}>...</{tag}>")
        return child

    def number(self) -> float:
        """Its text as a finite number.

        Raises:
            SceneError: If it is none.
        """
        try:
            value = float(self.text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise self.error(f"holds {self.text!r}", "a number is needed")
        return value


def parse_xml(file: str | os.PathLike[str]) -> Element:
    """The root element of a file.

    Raises:
        SceneError: If the file cannot be read, is not well-formed (the line is named), or declares a DTD or entities,
            which can make a small file fill all memory.
    """
    name = os.fspath(file)
    try:
        data = Path(file).read_bytes()
    except OSError as error:
        raise SceneError(name, "cannot be read", error.strerror or "") from error
    parser = expat.ParserCreate(namespace_separator="}")
    roots: list[Element] = []
    opened: list[Element] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(file=name, line=parser.CurrentLineNumber, tag=tag.rpartition("}")[2])
        (opened[-1].children if opened else roots).append(element)
        opened.append(element)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: opened.pop()
    parser.CharacterDataHandler = lambda text: opened[-1].texts.append(text)
    parser.StartDoctypeDeclHandler = _refusal(name, parser)
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        what = expat.ErrorString(error.code)
        raise SceneError(f"{name}, line {error.lineno}", f"is not well-formed XML ({what})", "repair it") from error
    return roots[0]


def _refusal(name: str, parser: expat.XMLParserType) -> Callable[..., None]:
    """What to do at a DTD."""

    def refuse(*declaration: object) -> None:
        raise SceneError(f"{name}, line {parser.CurrentLineNumber}", "declares a DTD", "remove the DOCTYPE")

    return refuse
