# SPDX-License-Identifier: MIT
"""Types of the functions that run jobs, made from the tables of their fields. Run as a program it writes them:
PYTHONPATH=build/release/python python3 tests/python/stubs.py"""
import re
import sys
from pathlib import Path
from textwrap import fill

import alidade
from alidade._jobs import _FIELDS, function_name, keyword

# What a command of the core returns. Those of extensions return what stands in their stubs.
RETURNS = {
    "catalog": "dict[str, Any]",
    "compare": "dict[str, Any]",
    "convert": "dict[str, Any]",
    "generate": "Cloud | None",
    "index": "dict[str, Any]",
    "info": "dict[str, Any]",
    "merge": "RenderedImage",
    "query": "Rows",
    "render": "Rendering",
    "sql": "Rows | list[Rows]",
    "sql load": "dict[str, Any]",
    "sql rewrite": "list[dict[str, Any]]",
    "visibility horizon": "Rows",
    "visibility lines": "Rows",
    "visibility points": "Points",
    "visibility raster": "Map",
    "visibility sky": "Map | Points",
    "visibility summary": "Rows",
    "visibility sun": "dict[str, Map] | Points | Rows",
}
ROOT = Path(__file__).resolve().parents[2]
BEGIN, END = "# Made by tests/python/stubs.py from here", "# to here"
LENGTHS = {"LENGTH", "METRES", "PIXELS", "STOPS", "R", "C", "DEGREES", "MINUTES", "S", "SHARE", "A", "B", "E", "F"}
COUNTS = {"N", "K", "0..255"}
OWN = ["workers: int = -1", "progress: Callable[[int, int], Any] | None = None", "note: Callable[[str], Any] | None = None"]


def type_of(kind, form):
    """The type of a field by its kind of value: the manual's word for it."""
    words = kind.split("|")
    if form == "flag":
        return "bool"
    if len(words) > 1 and all(word and word == word.lower() and not word[0].isdigit() for word in words):
        one = f"Literal[{', '.join(repr(word) for word in words)}]".replace("'", '"')
    elif kind in LENGTHS:
        one = "float"
    elif kind in COUNTS:
        one = "int"
    elif words[0] in LENGTHS | COUNTS or words[0].isdigit():
        one = "float | str"
    elif kind == "SIZE":
        one = "int | str"
    elif kind == "FILE|-":
        return "_File | ArrayLike"
    elif any(word in kind for word in ("FILE", "FOLDER", "CLOUD", "PART")) or kind in ("BEFORE", "AFTER", "REFERENCE", "TEST"):
        one = "_File"
    elif kind in ("WxH", "I/N"):
        one = "str | Sequence[int]"
    elif "," in kind:
        return "str | ArrayLike"
    else:
        one = "str"
    if kind == "BOX|FILE":
        return "_File | Sequence[float]"
    if kind.startswith(("LIST", "NAMES")):
        return "_List"
    if form not in ("repeated", "words"):
        return one
    return "_Files" if one == "_File" else f"{one} | Sequence[{one}]"


def function_text(command, returned):
    name = function_name(command)
    positional, named = [], []
    for field in _FIELDS[command]:
        _, kind, _, form, is_operand, is_required = field
        annotation = f"{keyword(field)}: {type_of(kind, form)}"
        if not (is_operand and is_required):
            annotation += " = False" if form == "flag" else " | None = None"
        (positional if is_operand else named).append(annotation)
    arguments = positional + ["*"] + named + OWN
    arguments[-1] += f") -> {returned}: ..."
    text = f"def\0{name}(" + ", ".join(argument.replace(" ", "\0") for argument in arguments)
    filled = fill(text, 124, subsequent_indent=" " * (len(name) + 5), break_long_words=False, break_on_hyphens=False)
    return filled.replace("\0", " ")


def stub_text(file, commands):
    """The stub with the functions of these commands."""
    text = file.read_text()
    begin, end = text.index(BEGIN) + len(BEGIN), text.index(END)

    def returned(command):
        return RETURNS.get(command) or re.search(rf"def {function_name(command)}\(.*?\) -> (.*?): \.\.\.", text, re.S)[1]
    return text[:begin] + "\n" + "".join(function_text(command, returned(command)) + "\n" for command in commands) + text[end:]


def stubs():
    """Every stub with functions of jobs, and its commands. Those of extensions are appended to those of the core."""
    found = {}
    for command in sorted(_FIELDS):
        name = "visibility.pyi" if command.startswith("visibility ") else "jobs.pyi"
        file = ROOT / "python/alidade" / name
        for added in ROOT.glob(f"extensions/*/{name}"):
            if f"\ndef {function_name(command)}(" in added.read_text():
                file = added
        found.setdefault(file, []).append(command)
    return found


if __name__ == "__main__":
    for file, commands in stubs().items():
        file.write_text(stub_text(file, commands))
    sys.exit(0)
