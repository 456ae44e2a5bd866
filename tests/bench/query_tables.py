# SPDX-License-Identifier: MIT
"""Tables of point queries and of lists along rays."""

from ray_tables import number, points_word, ratio, table

INDEXES = {"octree": "Alidade", "nanoflann": "nanoflann", "boost_packed": "Boost R*-tree, packed",
           "boost_inserted": "Boost R*-tree, inserted", "pcl": "PCL octree"}


def thousand(results, question, index, n):
    """Milliseconds for a thousand queries, as the paper counts."""
    return number(results.microseconds_per_query(f"points/{question}/{index}/{n}"))


def table_1(results, n=10**5):
    rows = []
    for index, word in INDEXES.items():
        build = results.milliseconds(f"points/build/{index}/{n}")
        if build is None:
            continue
        rows.append([word, number(build)] + [thousand(results, question, index, n) for question in
                                             ["nearest_8", "box_count_large", "box_ids_large", "box_count_small",
                                              "box_ids_small"]])
    two = results.milliseconds(f"points/build/octree_2_threads/{n}")
    rows.insert(1, ["Alidade, 2 threads", number(two)] + [""] * 5)
    return table(["index", "construction, ms", "nearest 8, ms", "large boxes: count, ms", "their ids, ms",
                  "small boxes: count, ms", "their ids, ms"], rows)


def mean_found(results, question, n):
    return number(results.median(f"points/{question}/octree/{n}", "found"), 4)


def points_table(results):
    rows = []
    for n in [10**5, 10**6, 10**7]:
        for index, word in INDEXES.items():
            build = results.milliseconds(f"points/build/{index}/{n}")
            if build is None:
                continue
            memory = results.median(f"points/build/{index}/{n}", "bytes_per_point") if n == 10**7 else None
            rows.append([points_word(n), word, number(build), number(memory)] +
                        [thousand(results, question, index, n) for question in
                         ["nearest_8", "within_20", "box_count_small", "box_ids_small"]])
    return table(["points", "index", "build, ms", "B/point", "nearest 8, us", "all within r, us", "box count, us",
                  "box ids, us"], rows)


def all_nearest_table(results, bar=1.4):
    rows = []
    for n in [10**6, 10**7]:
        for order, word in {"morton": "along a Morton curve", "raw": "random"}.items():
            ours, theirs = (results.microseconds_per_query(f"points/all_nearest_10_{order}/{index}/{n}")
                            for index in ["octree", "nanoflann"])
            if ours is not None:
                rows.append([points_word(n), word, number(ours), number(theirs),
                             ratio(theirs, ours, bar if order == "morton" else None)])
    return table(["points", "their order", "Alidade, us per point", "nanoflann", "nanoflann : Alidade"], rows)


def site_table(results, n=10**6):
    bars = {"nearest/1": 3, "nearest/8": 5, "nearest/64": 20, "closest_by_t": 0.6}
    words = {"nearest/1": "1 nearest to the ray", "nearest/8": "8 nearest to the ray", "nearest/64": "64 nearest to the ray",
             "closest_by_t": "closest by t within r"}
    rows = []
    for question, bar in bars.items():
        time = results.microseconds_per_query(f"site/{question}/{n}")
        if time is not None:
            rows.append([words[question], number(time) if time <= bar else f"**{number(time)}**", str(bar)])
    return table(["question", "us per ray", "bar"], rows)


def figure_5_table(results):
    rows = []
    for n in [10**6, 10**7, 10**8]:
        for question, parameters in [("nearest", ["1", "8", "64", "256"]), ("radius", ["0.001", "0.003", "0.01", "0.03"]),
                                     ("interval", ["0.000001", "0.00001", "0.0001", "0.001"]),
                                     ("closest_1", ["0.001", "0.003", "0.01", "0.03"])]:
            names = [f"uniform/{question}/{parameter}/{n}" for parameter in parameters]
            times = [results.microseconds_per_query(name) for name in names]
            if None in times:
                continue
            word = {"nearest": "k nearest, k =", "radius": "all within r =", "interval": "all in a time range of",
                    "closest_1": "closest within r ="}[question]
            found = [number(results.median(name, "found")) for name in names]
            rows.append([points_word(n), f"{word} {', '.join(parameters)}", ", ".join(map(number, times)), ", ".join(found)])
    return table(["points", "question", "us per ray", "points found"], rows)


def identical_table(results, n=10**6):
    rows = [[word, number(results.microseconds_per_query(f"identical/{word}/{n}"))] for word in ["closest", "occluded"]]
    return table(["question", "us per ray"], rows)
