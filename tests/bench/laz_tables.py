# SPDX-License-Identifier: MIT
"""Tables of compressed points."""

from ray_tables import number, table


def rate(results, name):
    """Million points per second."""
    per_second = results.median(name, "items_per_second")
    return None if per_second is None else per_second / 1e6


def codec_table(results):
    rows = []
    for name in sorted(results.names("decode/"), key=str.lower):
        source = name.partition("/")[2]
        rows.append([source.replace("made_format_", "made, format "), number(rate(results, name)),
                     number(rate(results, f"encode/{source}"))])
    return table(["points", "unpacked, M/s", "packed, M/s"], rows)


def files_table(results):
    rows = []
    for name in sorted(results.names("read/")):
        if "threads:1" not in name:
            continue
        one, two = rate(results, name), rate(results, name.replace("threads:1", "threads:2"))
        source = name.split("/")[1].replace("made_format_", "made, format ")
        rows.append([source, number(one), number(two), number(None if None in (one, two) else two / one)])
    return table(["points", "1 thread, M/s", "2 threads, M/s", "times"], rows)
