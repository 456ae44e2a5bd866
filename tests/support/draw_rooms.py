#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""draw_rooms.py [--check]: draws the rooms of the house into docs/images/rooms.svg, from their includes.

A box is a room, with its number of modules and lines; an arrow leads from a room to one that it includes from. Arrows that
follow from others are left out. --check writes nothing and fails if the picture is not the one that would be drawn.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PICTURE = ROOT / "docs/images/rooms.svg"
WORDS = {
    "base": "what every room needs", "cloud": "from file to points", "octree": "from points to hit",
    "surface": "from points to surfaces",
    "mesh": "from triangles to hit", "geo": "where on Earth", "image": "pixels", "camera": "from pixel to ray", "simulation": "a known world",
    "renderer": "from scene to image", "visibility": "from observers to maps", "compare": "two images, a verdict",
    "database": "from SQL to rows", "jobs": "from request to result", "tools": "the program alidade",
    "python": "the module alidade", "extensions": "what the core can do without",
}
# From left to right where rooms stand side by side.
COLUMNS = ["database", "compare", "renderer", "visibility", "octree", "surface", "mesh", "image", "geo", "camera", "simulation", "cloud", "base", "jobs", "tools", "python", "extensions"]
WIDTH, HEIGHT, GAP, RISE = 176, 56, 20, 64


def rooms():
    lines = (ROOT / "tests/support/rooms.txt").read_text().splitlines()
    return [line.split(":")[0] for line in lines if line and not line.startswith("#")]


def included_rooms(room, names):
    found = set()
    for path in (ROOT / room).rglob("*"):
        if path.suffix in (".h", ".cpp") and path.parent.name != "tests":
            for match in re.finditer(r'^ *# *include "([^"/]+)/', path.read_text(), re.M):
                if match[1] in names and match[1] != room:
                    found.add(match[1])
    return found


def drawing():
    names = rooms()
    below = {room: included_rooms(room, names) for room in names}
    users = {room: [user for user in names if room in below[user]] for room in names}
    # Each as high as it can stand, so that rooms side by side are drawn side by side.
    depth = {}
    for room in reversed(names):
        depth[room] = 1 + max((depth[user] for user in users[room]), default=-1)
    level = {room: max(depth.values()) - depth[room] for room in names}

    def reaches(room, other):
        return other in below[room] or any(reaches(next_room, other) for next_room in below[room])

    direct = {room: {other for other in below[room] if not any(reaches(third, other) for third in below[room] if third != other)}
              for room in names}
    top = max(level.values())
    rows = [[room for room in COLUMNS if level[room] == number] for number in range(top + 1)]
    width = max(len(row) for row in rows) * (WIDTH + GAP) + GAP
    height = (top + 1) * HEIGHT + top * RISE + 2 * GAP
    corner = {}
    for number, row in enumerate(rows):
        left = (width - len(row) * (WIDTH + GAP) + GAP) / 2
        for column, room in enumerate(row):
            corner[room] = (left + column * (WIDTH + GAP), GAP + (top - number) * (HEIGHT + RISE))
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif">',
             f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
             '<defs><marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
             '<path d="M0 0 8 4 0 8z" fill="#5a6b7b"/></marker></defs>']
    for room in names:
        above = sorted(direct[room], key=lambda other: corner[other][0])
        for number, other in enumerate(above):
            x = corner[room][0] + WIDTH * (number + 1) / (len(above) + 1)
            ends = sorted((user for user in names if other in direct[user]), key=lambda user: corner[user][0])
            end = corner[other][0] + WIDTH * (ends.index(room) + 1) / (len(ends) + 1)
            y, bottom = corner[room][1] + HEIGHT, corner[other][1]
            turn, middle = bottom - RISE, bottom - RISE / 2
            parts.append(f'<path d="M{x:.0f} {y:.0f}V{turn:.0f}C{x:.0f} {middle:.0f} {end:.0f} {middle:.0f} {end:.0f} {bottom:.0f}" '
                         'fill="none" stroke="#5a6b7b" stroke-width="1.4" marker-end="url(#head)"/>')
    for room in names:
        x, y = corner[room]
        parts.append(f'<rect x="{x:.0f}" y="{y:.0f}" width="{WIDTH}" height="{HEIGHT}" rx="6" fill="#eef3f7" stroke="#2f4858"/>')
        parts.append(f'<text x="{x + WIDTH / 2:.0f}" y="{y + 24:.0f}" text-anchor="middle" font-size="16" font-weight="bold" '
                     f'fill="#12232e">{room}/</text>')
        parts.append(f'<text x="{x + WIDTH / 2:.0f}" y="{y + 43:.0f}" text-anchor="middle" font-size="12" fill="#3c4f5c">{WORDS[room]}</text>')
    return "\n".join(parts + ["</svg>", ""])


def main():
    picture = drawing()
    if sys.argv[1:] == ["--check"]:
        if not PICTURE.exists() or PICTURE.read_text() != picture:
            sys.exit(f"{PICTURE.relative_to(ROOT)} is not what the includes say; run tests/support/draw_rooms.py")
    else:
        PICTURE.write_text(picture)


main()
