# SPDX-License-Identifier: MIT
"""Maps of what is visible, as `alidade visibility` makes them.

The fields are the options of the program, with _ for -. Their values are numbers, texts, True for options without a value,
sequences where the program takes a list, such as extent=(x0, y0, x1, y1), and sequences of sequences where an option may be
repeated, such as observer=[(x, y), (x, y, z)]."""
from textwrap import fill

from ._alidade import _raster, _raster_fields


def raster(files, *, workers=-1, progress=None, note=None, **fields):
    return _raster(files, workers=workers, progress=progress, note=note, **fields)


def _described(function, summary, fields):
    text = [summary, "", "Parameters", "----------", "files : file or list of files",
            "    Cloud files, folders, patterns, an index file, or a table of a database; or an elevation raster.",
            "workers : int", "    Number of threads; -1: all.",
            "progress : function", "    Called with the work done and all work of each stage; what it raises ends the work.",
            "note : function", "    Called at the end with each text that the program would print."]
    for name, kind, help_text, form in fields:
        text.append(f"{name} : {kind or 'bool'}" + (", or a sequence of them" if form == "repeated" else ""))
        text.append(fill(help_text[0].upper() + help_text[1:] + ".", 96, initial_indent="    ", subsequent_indent="    "))
    function.__doc__ = "\n".join(text)


_described(raster, """Compute a viewshed of the ground, or of objects from the ground: an alidade.Map.

Without `output` nothing is written. The map is that of `alidade visibility raster`, whose manual explains the modes.""",
           _raster_fields())
