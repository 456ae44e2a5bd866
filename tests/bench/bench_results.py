# SPDX-License-Identifier: MIT
"""What the benchmarks printed, by name: medians over repetitions."""

import json
import statistics


class Results:
    """Times are milliseconds, rates per second; None where nothing was measured."""

    def __init__(self, folder):
        self.samples = {}
        self.runs = json.loads((folder / "runs.json").read_text())
        for name in self.runs:
            for sample in json.loads((folder / f"{name}.json").read_text())["benchmarks"]:
                if sample["run_type"] == "iteration":
                    key = sample["run_name"].split("/iterations:")[0]
                    self.samples.setdefault(key, []).append(sample)

    def names(self, start):
        return [name for name in self.samples if name.startswith(start)]

    def median(self, name, figure):
        samples = self.samples.get(name)
        if not samples or figure not in samples[0]:
            return None
        return statistics.median(sample[figure] for sample in samples)

    def milliseconds(self, name):
        """By the clock for several threads, otherwise processor time."""
        clock = any("real_time" in sample["run_name"] for sample in self.samples.get(name, []))
        return self.median(name, "real_time" if clock else "cpu_time")

    def rate(self, name):
        return self.median(name, "rays")

    def microseconds_per_query(self, name):
        rate = self.median(name, "queries")
        return None if rate is None else 1e6 / rate

    def largest_foreign_load(self):
        return max(run["foreign_cores"] for run in self.runs.values())
