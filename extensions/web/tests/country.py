# SPDX-License-Identifier: MIT
"""country.py PROGRAM [SIDE [POINTS]]: measures rays through a simulated country of SIDE * SIDE COPC tiles on a server.

All tiles have the same points, of a scanned courtyard; the server moves them when they are requested. By default there
are 10,000 tiles of 2 million points. Prints requests, bytes and seconds, with 20 ms of delay for each request.
"""

import gzip
import os
import re
import struct
import subprocess
import sys
import tempfile
import time

import range_server

TILE_SIDE = 120.0  # metres; the courtyard is a little smaller
EAST, NORTH = 690000.0, 5325000.0  # of the courtyard's middle


HEADER_SIZE = 589  # of LAS, and the record of COPC


class MovedTile:
    """The bytes of a COPC file whose points lie elsewhere: only its beginning is another one."""

    def __init__(self, tile, east, north):
        self.header, self.tile = moved_header(tile[:HEADER_SIZE], east, north), tile

    def __len__(self):
        return len(self.tile)

    def __getitem__(self, part):
        first, end, _ = part.indices(len(self.tile))
        return self.header[first:end] + self.tile[max(first, HEADER_SIZE):end]


def moved_header(tile, east, north):
    """With another offset and other bounds, and another centre of the octree."""
    moved = bytearray(tile)
    for byte, by in ((155, east), (163, north), (179, east), (187, east), (195, north), (203, north), (429, east),
                     (437, north)):
        struct.pack_into("<d", moved, byte, struct.unpack_from("<d", tile, byte)[0] + by)
    return bytes(moved)


def tile_names(side):
    return [f"tile_{x:03}_{y:03}.copc.laz" for x in range(side) for y in range(side)]


class Country(range_server.RangeServer):
    """Serves tiles tile_X_Y.copc.laz, whatever X and Y, beside the files of a folder."""

    def __init__(self, folder, tile):
        super().__init__(folder)
        with open(tile, "rb") as file:
            self.tile = file.read()

    def content(self, name):
        found = re.fullmatch(r"tile_(\d+)_(\d+)\.copc\.laz", name)
        if not found:
            return super().content(name)
        return MovedTile(self.tile, TILE_SIDE * int(found[1]), TILE_SIDE * int(found[2]))


def rays(side):
    """A vertical ray in the middle of the country, and one that comes down over some tiles."""
    east, north = EAST + TILE_SIDE * (side // 2) + 3, NORTH + TILE_SIDE * (side // 2) + 2
    return {"vertical": f"{east},{north},700,0,0,-1", "slanted": f"{east},{north},620,1,0.3,-0.04"}


def main(program, side=100, points=2_000_000):
    with tempfile.TemporaryDirectory() as folder:
        def run(*words):
            begin = time.monotonic()
            done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                sys.exit(done.stderr)
            return done, time.monotonic() - begin

        run("generate", "courtyard", "--points", str(points), "-o", "tile.las", "-q")
        run("convert", "tile.las", "-o", "tile.copc.laz", "-q")
        server = Country(folder, os.path.join(folder, "tile.copc.laz"))
        base = server.address("good", "")
        _, seconds = run("catalog", *(base + name for name in tile_names(side)), "-o", "site.catalog.json", "-q")
        print(f"{side * side} tiles of {points} points in {len(server.tile)} bytes; catalog made in {seconds:.1f} s, "
              f"{server.requests} requests, {server.sent} bytes")
        path = os.path.join(folder, "site.catalog.json")
        with open(path, encoding="utf-8") as file:
            text = file.read().replace(base, "")
        with open(path, "w", encoding="utf-8") as file:
            file.write(text)
        with gzip.open(path + ".gz", "wb") as file:
            file.write(text.encode())
        for catalog in ("site.catalog.json", "site.catalog.json.gz"):
            print(f"{catalog}: {os.path.getsize(os.path.join(folder, catalog))} bytes")
            for name, ray in rays(side).items():
                for limit in (["--k", "1"], []):
                    server.forget()
                    done, seconds = run("query", server.address("slow", catalog), "--ray", ray, "--radius", "0.25",
                                        *limit, "--explain", "-q")
                    told = re.search(r"files opened +(\d+)", done.stderr)[1]
                    print(f"  {name:9} {' '.join(limit) or 'all':6} {done.stdout.count(chr(10)) - 1:6} points, "
                          f"{told:>3} files, "
                          f"{server.requests:4} requests, {server.sent:9} bytes, {seconds:.2f} s")
        server.shutdown()


if __name__ == "__main__":
    main(os.path.abspath(sys.argv[1]), *(int(word) for word in sys.argv[2:]))
