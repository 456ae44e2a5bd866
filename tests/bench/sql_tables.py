# SPDX-License-Identifier: MIT
"""Tables of the paper's database."""

from laz_tables import rate
from ray_tables import number, table

QUESTIONS = [("ray/1/pruned", "`dist_ray(...) <= 1`"), ("ray/1/plain", "the same, nothing left out"),
             ("ray/0.1/pruned", "`dist_ray(...) <= 0.1`"), ("ray/0.1/plain", "the same, nothing left out"),
             ("ray_form/1", "`points(ray) WHERE dist <= 1`"),
             ("first_hit/1", "`... AND t >= 0 ORDER BY t LIMIT 1`")]


def load_table(results):
    rows = [[memory, number(rate(results, f"sql/{name}"))]
            for name, memory in [("load", "1 GB"), ("load_128M", "128 MB")]]
    return table(["memory for points", "M points/s"], rows)


def queries_table(results):
    rows = []
    for name, text in QUESTIONS:
        name = f"sql/{name}"
        read, chunks = results.median(name, "chunks_read"), results.median(name, "chunks")
        share = None if None in (read, chunks) else 100 * read / chunks
        rows.append([text, number(results.median(name, "rows")), number(results.milliseconds(name)), number(share)])
    return table(["statement", "rows", "ms", "% of chunks read"], rows)
