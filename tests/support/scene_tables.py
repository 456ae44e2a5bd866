#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that the tables of docs/scene_format.md are those of scenes/schema/scene.schema.json; --write writes them."""
import json
import pathlib
import re
import sys

PAGE = pathlib.Path("docs/scene_format.md")
SCHEMA = json.loads(pathlib.Path("scenes/schema/scene.schema.json").read_text())
POWERS = {10**9: "10⁹", 10**12: "10¹²", 1e300: "10³⁰⁰", 2**64 - 1: "2⁶⁴-1"}
ROOT = SCHEMA["properties"]


def resolved(schema):
    name = schema.get("$ref", "").removeprefix("#/$defs/")
    return SCHEMA["$defs"][name] | schema if name in SCHEMA["$defs"] else schema


def code(value):
    return "`" + json.dumps(value, ensure_ascii=False) + "`"


def number(value):
    return POWERS.get(value, f"{value:g}" if isinstance(value, float) else str(value))


def limits(schema):
    """What JSON Schema says of a number, in words."""
    low, high = schema.get("minimum", schema.get("exclusiveMinimum")), schema.get("maximum", schema.get("exclusiveMaximum"))
    if "exclusiveMinimum" in schema:
        return f"above {number(low)}, to {number(high)}"
    if "exclusiveMaximum" in schema:
        return f"{number(low)} to below {number(high)}"
    return f"±{number(high)}" if low == -high and high > 1000 else f"{number(low)} to {number(high)}"


def values(schema):
    if "oneOf" in schema:
        each = schema["oneOf"]
        if all("type" in one.get("properties", {}) for one in each):
            return "an object with `type` " + ", ".join(code(one["properties"]["type"]["const"]) for one in each)
        return "; or ".join(dict.fromkeys(filter(None, map(values, each))))
    if "enum" in schema:
        return ", ".join(map(code, schema["enum"]))
    if "const" in schema:
        return code(schema["const"])
    kind = schema.get("type")
    if kind in ("number", "integer"):
        return limits(schema)
    if kind == "boolean":
        return "`true`, `false`"
    if kind == "object":
        return "an object"
    if kind == "string":
        return "a text"
    if kind == "array":
        item = values(schema["items"])
        if "minItems" in schema and schema.get("maxItems") == schema["minItems"]:
            return f"{schema['minItems']} numbers, {item}"
        return f"a list of {item}" if "enum" in schema["items"] else "a list"
    return ""


def default(name, schema, required):
    if name in required:
        return "required"
    if "default" not in schema:
        return "–"
    value = schema["default"]
    if isinstance(value, dict) and "type" in value:
        albedo = f", albedo {value['albedo'][0]}" if "albedo" in value else ""
        return value["type"] + albedo
    return "see below" if isinstance(value, dict) else code(value) if isinstance(value, (str, list, bool)) else number(value)


def meaning(schema):
    words = schema.get("enum", []) + [each["const"] for each in schema.get("oneOf", []) if "const" in each]
    for each in schema.get("oneOf", []):
        words += each.get("enum", [])
    text = schema.get("description", "")
    for word in filter(lambda word: isinstance(word, str), words):
        text = re.sub(rf"(?<![\w\"]){re.escape(word)}:", f'`"{word}"`:', text)
    return text


def rows(schema, first=None):
    for name, each in schema["properties"].items():
        each = resolved(each)
        if first and name == "type":
            continue
        yield ([first] if first else []) + [f"`{name}`", meaning(each), default(name, each, schema.get("required", [])), values(each)]
        if first:
            first = " "


def table(title, lines):
    lines = [title, ["---"] * len(title), *lines]
    return "".join("|" + "|".join(f" {cell.strip()} " if cell.strip() else " " for cell in line) + "|\n" for line in lines).replace(" --- ", "---")


def keys(schema):
    return table(["key", "meaning", "default", "values"], rows(schema))


def kinds(schema):
    lines = []
    for each in schema["oneOf"]:
        lines += rows(each, f"`{each['properties']['type']['const']}`: {each['description']}")
    return table(["`type`", "key", "meaning", "default", "values"], lines)


def tables():
    cloud = ROOT["cloud"]["properties"]
    by_angles, by_time = ROOT["sun"]["oneOf"]
    coloring = cloud["color"]["oneOf"][1]
    return {"scene": keys(SCHEMA), "cloud": keys(ROOT["cloud"]), "radius": keys(cloud["radius"]["oneOf"][2]),
            "color": keys(coloring), "classes": keys(coloring["properties"]["classes"]["items"]),
            "objects": kinds(ROOT["objects"]["items"]), "material": kinds(resolved(cloud["material"])), "sky": kinds(ROOT["sky"]),
            "sun": keys(by_angles), "sun by time": keys(by_time), "render": keys(ROOT["render"]), "output": keys(ROOT["output"])}


def main():
    page = PAGE.read_text()
    written = page
    for name, text in tables().items():
        begin, end = f"<!-- keys: {name} -->\n", "<!-- end -->\n"
        if begin not in written:
            sys.exit(f"{PAGE}: missing '{begin.strip()}'")
        head, rest = written.split(begin, 1)
        written = head + begin + text + end + rest.split(end, 1)[1]
    if written == page:
        return
    if sys.argv[1:] == ["--write"]:
        PAGE.write_text(written)
    else:
        sys.exit(f"{PAGE}: the tables are not those of the schema; run tests/support/scene_tables.py --write")


if __name__ == "__main__":
    main()
