#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""A simulated town for runs on clouds larger than memory: LAZ tiles of scans of the courtyard, side by side.

make_town.py ALIDADE FOLDER [--tiles 40] [--scans 8] [--points 25000000]

Each scan has a seed of its own and is placed several times. The tiles have LAS point format 2 with colours of 8 bits, as many archives
do, and take about 4 bytes per point."""

import argparse
import pathlib
import struct
import subprocess
import tempfile

import numpy

LAS_7 = numpy.dtype([("xyz", "<i4", 3), ("intensity", "<u2"), ("returns", "u1"), ("flags", "u1"), ("class", "u1"),
                     ("user", "u1"), ("angle", "<i2"), ("source", "<u2"), ("time", "<f8"), ("rgb", "<u2", 3)])
LAS_2 = numpy.dtype([("xyz", "<i4", 3), ("intensity", "<u2"), ("returns", "u1"), ("class", "u1"), ("angle", "i1"),
                     ("user", "u1"), ("source", "<u2"), ("rgb", "<u2", 3)])
OFFSET, BOUNDS = 155, 179  # bytes of the LAS header
PITCH = (124.0, 106.0)     # metres from tile to tile
COLUMNS = 8


def header_of_format_2(count, scale, offset, low, high):
    header = bytearray(227)
    header[0:4] = b"LASF"
    header[24:26] = bytes([1, 2])
    struct.pack_into("<HHHI", header, 90, 1, 2026, 227, 227)
    struct.pack_into("<BHII", header, 104, 2, LAS_2.itemsize, count, count)
    struct.pack_into("<6d", header, 131, *scale, *offset)
    bounds = [offset[axis] + scale[axis] * int(end[axis]) for axis in range(3) for end in (high, low)]
    struct.pack_into("<6d", header, BOUNDS, *bounds)
    return header


def write_scan(alidade, folder, seed, points):
    """A scan as LAZ of point format 2."""
    full, plain, packed = (folder / name for name in ("full.las", "plain.las", f"scan{seed}.laz"))
    subprocess.run([alidade, "generate", "courtyard", "--points", str(points), "--seed", str(seed), "-o", full, "-q"], check=True)
    with open(full, "rb") as file:
        start = file.read(375)
    begin, = struct.unpack_from("<I", start, 96)
    source = numpy.memmap(full, LAS_7, "r", begin, points)
    with open(plain, "wb") as file:
        file.write(header_of_format_2(points, struct.unpack_from("<3d", start, 131), struct.unpack_from("<3d", start, OFFSET),
                                      source["xyz"].min(0), source["xyz"].max(0)))
        for first in range(0, points, 1 << 20):
            some = source[first:first + (1 << 20)]
            rows = numpy.zeros(len(some), LAS_2)
            for name in ("xyz", "intensity", "class"):
                rows[name] = some[name]
            rows["returns"] = 1 | 1 << 3
            rows["rgb"] = some["rgb"] >> 8
            file.write(rows.tobytes())
    full.unlink()
    subprocess.run([alidade, "convert", plain, "-o", packed, "-q"], check=True)
    plain.unlink()
    return packed


def place(scan, tile, row, column):
    """A copy of the scan at another position."""
    content = bytearray(scan.read_bytes())
    for axis, steps in enumerate((column, row)):
        for at in (OFFSET + 8 * axis, BOUNDS + 16 * axis, BOUNDS + 16 * axis + 8):
            struct.pack_into("<d", content, at, struct.unpack_from("<d", content, at)[0] + steps * PITCH[axis])
    tile.write_bytes(content)


def make_town(arguments, scratch):
    for seed in range(1, min(arguments.scans, arguments.tiles) + 1):
        scan = write_scan(arguments.alidade, scratch, seed, arguments.points)
        for number in range(seed - 1, arguments.tiles, arguments.scans):
            row, column = divmod(number, COLUMNS)
            place(scan, arguments.folder / f"tile{row:02}{column}.laz", row, column)
        scan.unlink()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("alidade")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--tiles", type=int, default=40)
    parser.add_argument("--scans", type=int, default=8)
    parser.add_argument("--points", type=int, default=25_000_000, help="of each tile")
    arguments = parser.parse_args()
    if arguments.folder.exists():
        parser.error(f"{arguments.folder} exists; expected a new folder")
    arguments.folder.mkdir(parents=True)
    with tempfile.TemporaryDirectory(dir=arguments.folder.parent) as scratch:
        make_town(arguments, pathlib.Path(scratch))


if __name__ == "__main__":
    main()
