# SPDX-License-Identifier: MIT
"""Commands of the program as functions: their fields come from the tables that also make its options."""
import inspect
from keyword import iskeyword
from operator import index
from textwrap import fill

from ._alidade import _added_jobs, _job_fields, _run_job  # type: ignore[import]

_FIELDS = _job_fields()


def keyword(field):
    """The name of a field; words of Python get an underscore: `from_`."""
    return field[0] + "_" * iskeyword(field[0])


def function_name(command):
    """"points" of "visibility points", "sql_load" of "sql load"."""
    return command.removeprefix("visibility ").replace(" ", "_").replace("-", "_")


def _described(summary, command, fields):
    text = [summary, "", f"See the manual: `alidade {command} --help`. Without `output` no file is written.", "", "Parameters", "----------"]
    for field in fields:
        _, kind, help_text, form, _, _ = field
        text.append(f"{keyword(field)} : {kind or 'bool'}" + (", or a sequence of them" if form in ("repeated", "words") else ""))
        text.append(fill(help_text[0].upper() + help_text[1:] + ".", 96, initial_indent="    ", subsequent_indent="    "))
    text += ["workers : int", "    Number of threads; -1: all.",
             "progress : function", "    Called with the work done and all work of each stage; what it raises ends the work.",
             "note : function", "    Called at the end with each text that the program would print."]
    return "\n".join(text)


def job(command, summary):
    """The function for a command, such as "visibility raster"."""
    fields = _FIELDS[command]
    operands = [field for field in fields if field[4]]
    names = {keyword(field): field[0] for field in fields}

    def call(*given, workers=-1, progress=None, note=None, **values):
        if len(given) > len(operands):
            raise TypeError(f"{call.__name__}() takes {len(operands)} positional arguments but {len(given)} were given")
        for field, value in zip(operands, given):
            if keyword(field) in values:
                raise TypeError(f"{call.__name__}() got multiple values for argument {keyword(field)!r}")
            values[keyword(field)] = value
        for name, function in (("progress", progress), ("note", note)):
            if function is not None and not callable(function):
                raise TypeError(f"{name}: expected a function, found {type(function).__name__}")
        threads = max(-1, min(index(workers), 2**31 - 1))
        return _run_job(command, {names.get(name, name): value for name, value in values.items()}, threads, progress, note)

    call.__name__ = call.__qualname__ = function_name(command)
    call.__doc__ = _described(summary, command, fields)
    parameter = inspect.Parameter
    own = [("workers", -1), ("progress", None), ("note", None)]
    call.__signature__ = inspect.Signature(
        [parameter(keyword(field), parameter.POSITIONAL_OR_KEYWORD, default=parameter.empty if field[5] else None)
         for field in operands]
        + [parameter(keyword(field), parameter.KEYWORD_ONLY, default=False if field[3] == "flag" else None)
           for field in fields if not field[4]]
        + [parameter(name, parameter.KEYWORD_ONLY, default=default) for name, default in own])
    return call


def added_jobs(is_wanted):
    """The functions of the commands of extensions, by their names, of those commands that are wanted."""
    return {function_name(command): job(command, summary) for command, summary in _added_jobs().items() if is_wanted(command)}
