# SPDX-License-Identifier: MIT
"""Plots of docs/reports/benchmarks.md, log-log; every curve has a colour of Okabe and Ito's palette, a marker and a dash."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plot  # noqa: E402
from ray_tables import SETS, SIZES, embree_best, points_word  # noqa: E402

plot.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "alidade", "font.size": 9, "axes.grid": True,
                      "grid.alpha": 0.4, "lines.markersize": 4, "lines.linewidth": 1.4, "legend.fontsize": 8})
STYLES = [("#0072B2", "o", "-"), ("#D55E00", "s", "--"), ("#009E73", "^", "-."), ("#CC79A7", "D", ":")]


def curve(axes, style, points, label):
    points = [(x, y) for x, y in points if y is not None]
    if points:
        colour, marker, dash = STYLES[style]
        axes.loglog(*zip(*points), color=colour, marker=marker, linestyle=dash, label=label)


def save(figure, path):
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plot.close(figure)


def rays(results, path):
    panels = [("closest", "P"), ("closest", "S_shuffled"), ("occluded", "S_shuffled"), ("occluded", "A_sun")]
    figure, all_axes = plot.subplots(1, 4, figsize=(11, 2.8), sharey=True)
    for axes, (question, kind) in zip(all_axes, panels):
        for style, mode in enumerate(["batch", "single"]):
            curve(axes, style, [(n, mega(results.rate(f"{question}/{kind}/{mode}/{n}"))) for n in SIZES], mode)
        curve(axes, 2, [(n, mega(embree_best(results, question, kind, n)[0])) for n in SIZES], "Embree, its best")
        axes.set_title(f"{question}, {SETS[kind]}")
        axes.set_xlabel("points")
    ticks = [0.5, 1, 2, 5, 10, 20]
    all_axes[0].set_yticks(ticks, [str(tick) for tick in ticks])
    all_axes[0].minorticks_off()
    all_axes[0].set_ylabel("million rays per second, 1 thread")
    all_axes[0].legend()
    save(figure, path)


def mega(rate):
    return None if rate is None else rate / 1e6


def builds(results, path):
    figure, axes = plot.subplots(figsize=(4.5, 3))
    for style, (name, label) in enumerate([("octree_2_threads", "octree"), ("wide_2_threads", "octree, wide cloud"),
                                           ("embree_2_threads", "Embree spheres")]):
        times = [(n, results.milliseconds(f"build/{name}/{n}")) for n in SIZES]
        curve(axes, style, [(n, None if t is None else t / 1000) for n, t in times], label)
    axes.set_xlabel("points")
    axes.set_ylabel("seconds, 2 threads")
    axes.legend()
    save(figure, path)


def figure_5(results, path):
    figure, (nearest, radius, closest) = plot.subplots(1, 3, figsize=(11, 3.2), sharey=True)
    for style, n in enumerate([10**6, 10**7, 10**8]):
        ks = [1, 2, 4, 8, 16, 32, 64, 128, 256]
        curve(nearest, style, [(k, results.microseconds_per_query(f"uniform/nearest/{k}/{n}")) for k in ks],
              f"{points_word(n)} points")
        for axes, question in [(radius, "radius"), (closest, "closest_1")]:
            curve(axes, style, [(float(r), results.microseconds_per_query(f"uniform/{question}/{r}/{n}"))
                                for r in ["0.0003", "0.001", "0.003", "0.01", "0.03"]], f"{points_word(n)} points")
    for axes, title, label in [(nearest, "k nearest to the ray", "k"), (radius, "all within r", "r"),
                               (closest, "closest within r", "r")]:
        axes.set_title(title)
        axes.set_xlabel(label)
    nearest.set_ylabel("microseconds per ray, 1 thread")
    nearest.legend()
    save(figure, path)
