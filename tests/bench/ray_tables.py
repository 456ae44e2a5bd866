# SPDX-License-Identifier: MIT
"""Tables of rays on the campus."""

SIZES = [10**6, 10**7, 5 * 10**7, 10**8]
EMBREE_MODES = ["single", "packet8", "packet16", "stream"]
SETS = {"P": "primary", "S": "bounce", "S_shuffled": "bounce, shuffled", "A_sun": "to the sun", "A_vis": "visibility"}


def points_word(n):
    return f"{n // 10**6} M" if n >= 10**6 else f"{n // 1000} k"


def number(value, digits=3):
    """With so many digits that count."""
    if value is None:
        return "–"
    text = f"{value:.{digits}g}"
    if "e" in text:
        text = f"{value:.0f}"
    return text


def table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "|".join(["---"] + ["--:"] * (len(header) - 1)) + "|"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def bar_of(question, mode, rays, n):
    """The ratio to Embree that this project wants to reach; None where it has set none."""
    coherent, large = rays == "P", n >= 5 * 10**7
    if question == "closest" and mode == "single" and n >= 10**7 and rays != "A_sun":
        return (1.1 if large else 1.0) if coherent else (1.6 if large else 1.45)
    if question == "closest" and mode == "batch" and n >= 10**7:
        return 2.0 if coherent else (2.5 if large else 2.1)
    if question == "closest" and mode == "blocks_of_256" and n == 5 * 10**7 and rays == "S_shuffled":
        return 2.0
    if question == "occluded" and mode == "batch":
        return 1.0 if rays == "A_sun" else 1.8 if coherent else 2.1
    return None


def embree_best(results, question, rays, n, threads=""):
    """(rate, mode) of Embree's fastest way to answer whole sets."""
    rates = [(results.rate(f"embree/{question}/{rays}/{mode}{threads}/{n}"), mode) for mode in EMBREE_MODES]
    return max((rate for rate in rates if rate[0]), default=(None, ""))


def ratio(ours, theirs, bar):
    if not ours or not theirs:
        return "–"
    quotient = ours / theirs
    if bar is None:
        return f"{quotient:.2f}"
    return f"{quotient:.2f} ({bar})" if quotient >= bar else f"**{quotient:.2f}** ({bar})"


def rays_table(results, question):
    rows = []
    for n in SIZES:
        for rays, word in SETS.items():
            rates = {mode: results.rate(f"{question}/{rays}/{mode}/{n}") for mode in ["single", "batch", "blocks_of_256"]}
            if rates["single"] is None:
                continue
            embree_single = results.rate(f"embree/{question}/{rays}/single/{n}")
            best, best_mode = embree_best(results, question, rays, n)
            row = [points_word(n), word, mega(embree_single), f"{mega(best)} {best_mode}" if best else "–"]
            for mode, rate in rates.items():
                row.append(mega(rate))
                row.append(ratio(rate, embree_single if mode == "single" else best, bar_of(question, mode, rays, n)))
            rows.append(row)
    return table(["points", "rays", "Embree single", "Embree best", "single", ": Embree single", "batch", ": Embree best",
                  "blocks of 256", ": Embree best"], rows)


def mega(rate):
    return number(None if rate is None else rate / 1e6)


def threads_table(results):
    rows = []
    for n in SIZES:
        for rays in ["P", "S", "S_shuffled"]:
            row = [points_word(n), SETS[rays]]
            for mode in ["single", "batch"]:
                one, two = (results.rate(f"closest/{rays}/{mode}{suffix}/{n}") for suffix in ["", "_2_threads"])
                row += [mega(one), mega(two), f"{two / one:.2f}" if one and two else "–"]
            best = embree_best(results, "closest", rays, n, "_2_threads")[0]
            batch = results.rate(f"closest/{rays}/batch_2_threads/{n}")
            row += [mega(best), ratio(batch, best, None)]
            if row[2] != "–":
                rows.append(row)
    return table(["points", "rays", "single, 1 thread", "2 threads", "times", "batch, 1 thread", "2 threads", "times",
                  "Embree best, 2 threads", "batch : Embree"], rows)


def instruction_sets_table(results, n=10**6):
    names = []
    for name in results.names("instruction_set/"):
        word = name.split("/")[1]
        if word not in names:
            names.append(word)
    order = [name for name in ["scalar", "sse4", "avx2", "avx512"] if name in names]
    rows = []
    for question in ["closest", "occluded"]:
        for rays in ["P", "S"]:
            for mode in ["single", "batch"]:
                rates = [results.rate(f"instruction_set/{name}/{question}/{rays}/{mode}/{n}") for name in order]
                if None in rates:
                    continue
                wide = dict(zip(order, rates))
                share = f"{wide['avx2'] / wide['avx512']:.2f}" if {"avx2", "avx512"} <= wide.keys() else "–"
                rows.append([question, SETS[rays], mode] + [mega(rate) for rate in rates] + [share])
    return table(["query", "rays", "asked", *order, "avx2 : avx512"], rows)


def instructions_table(results, n=10**6):
    def count(name, figure="instructions"):
        value = results.median(name, figure)
        return "–" if value is None else f"{value:.0f}" if value > 100 else f"{value:.1f}"

    rows = []
    for question, sets in [("closest", ["P", "S"]), ("occluded", ["P", "S", "A_sun", "A_vis"])]:
        for rays in sets:
            ours = f"instructions/{question}/{rays}"
            if results.median(f"{ours}/single/{n}", "instructions") is None:
                continue
            row = [question, SETS[rays], count(f"{ours}/single/{n}"), count(f"embree/{ours}/single/{n}"), count(f"{ours}/batch/{n}")]
            row += [count(f"embree/{ours}/{mode}/{n}") for mode in EMBREE_MODES[1:]]
            rows.append(row + [count(f"{ours}/single/{n}", figure) for figure in ["nodes", "leaves", "bytes"]])
    return table(["query", "rays", "single", "Embree single", "batch", *(f"Embree {mode}" for mode in EMBREE_MODES[1:]),
                  "nodes", "leaves", "bytes"], rows)


def python_table(results, bar=5):
    rows = []
    for n in [10**6, 10**7]:
        for rays in ["P", "S_shuffled"]:
            for threads, suffix in [("1", ""), ("2", "_2_threads")]:
                cpp, numpy = (results.rate(f"python/closest/{rays}/{mode}{suffix}/{n}") for mode in ["cpp", "numpy"])
                if cpp is None or numpy is None:
                    continue
                more = 100 * (cpp / numpy - 1)
                word = f"{more:.1f} ({bar})" if more <= bar else f"**{more:.1f}** ({bar})"
                rows.append([points_word(n), SETS[rays], threads, mega(cpp), mega(numpy), word])
    return table(["points", "rays", "threads", "C++", "NumPy", "more time from NumPy, %"], rows)


def build_table(results):
    rows = []
    for n in SIZES:
        one, two, wide = (results.milliseconds(f"build/{name}/{n}") for name in ["octree", "octree_2_threads", "wide_2_threads"])
        if one is None:
            continue
        embree = results.milliseconds(f"build/embree_2_threads/{n}")
        row = [points_word(n)] + [number(None if t is None else t / 1000) for t in [one, two, wide, embree]]
        row.append(number(results.median(f"build/octree_2_threads/{n}", "peak_bytes_per_point")))
        for name, figure in [("octree_2_threads", "bytes_per_point"), ("without_ids_2_threads", "bytes_per_point"),
                             ("embree_2_threads", "bytes_per_point"), ("embree_2_threads", "allocated_bytes_per_point")]:
            row.append(number(results.median(f"build/{name}/{n}", figure)))
        rows.append(row)
    return table(["points", "build, 1 thread, s", "2 threads, s", "wide cloud, 2 threads, s", "Embree, 2 threads, s",
                  "peak B/point", "octree B/point", "without ids B/point", "Embree resident B/point",
                  "Embree allocated B/point"], rows)
