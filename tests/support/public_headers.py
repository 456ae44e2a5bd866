#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that the public headers (cmake/public_headers.txt) include no internal one and no library that users need not
have, and that the tables of docs/architecture.md are those of the list; --write writes the tables, --doxygen prints the
headers as an input of Doxygen."""
import pathlib
import re
import sys

LIST = pathlib.Path("cmake/public_headers.txt")
PAGE = pathlib.Path("docs/architecture.md")
BEGIN = "<!-- public headers: cmake/public_headers.txt, written by tests/support/public_headers.py -->\n"
END = "<!-- end of public headers -->\n"
PRIVATE_LIBRARIES = re.compile(r"(tbb|oneapi|nlohmann|pugixml|hwy|OpenImageIO|gdal|ogr|cpl_|CLI|sqlite3|libpq)")


def read_list():
    """[(title, [(header, content)])]"""
    tables = []
    for line in LIST.read_text().splitlines():
        if "|" in line and not line.startswith("#"):
            header, content = line.split("|", 1)
            tables[-1][1].append((header.strip(), content.strip()))
        elif line.startswith("# ") and " | " not in line:
            tables.append((line[2:], []))
    return [table for table in tables if table[1]]


def as_markdown(tables):
    text = ""
    for title, rows in tables:
        text += f"\n### {title}\n\n| header | content |\n|---|---|\n"
        text += "".join(f"| [{header}](../{header}) | {content} |\n" for header, content in rows)
    return text + "\n"


def problems_of(headers):
    order = {header: number for number, header in enumerate(headers)}
    for header in headers:
        if not pathlib.Path(header).is_file():
            yield f"{LIST}: {header} does not exist"
            continue
        for mark, included in re.findall(r'^\s*#\s*include\s+(["<])([^">]+)', pathlib.Path(header).read_text(), re.M):
            if mark == "<" and PRIVATE_LIBRARIES.match(included):
                yield f"{header}: is public and includes {included}; a public header needs only the standard library and GLM"
            elif mark == '"' and included not in order:
                yield f"{header}: is public and includes {included}, which is not in {LIST}"
            elif mark == '"' and order[included] >= order[header]:
                yield f"{header}: includes {included}, which is listed later in {LIST}"


def main():
    tables = read_list()
    headers = [header for _, rows in tables for header, _ in rows]
    if sys.argv[1:] == ["--doxygen"]:
        print("INPUT = docs/api/main.md", *headers)
        return
    page = PAGE.read_text()
    before, _, rest = page.partition(BEGIN)
    after = rest.partition(END)[2]
    expected = before + BEGIN + as_markdown(tables) + END + after
    if sys.argv[1:] == ["--write"]:
        PAGE.write_text(expected)
        return
    problems = list(problems_of(headers))
    if page != expected:
        problems.append(f"{PAGE}: the tables of headers are not those of {LIST}; run tests/support/public_headers.py --write")
    for problem in problems:
        print(problem, file=sys.stderr)
    if problems:
        sys.exit(f"{len(problems)} problems with public headers")
    print(f"{len(headers)} public headers")


if __name__ == "__main__":
    main()
