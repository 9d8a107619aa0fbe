#!/usr/bin/env python3
"""Draws accuracy_integrators.csv, made by accuracy.sh, as SVG for docs/micropolar.md. Usage: plot_accuracy.py OUT_FOLDER"""

import math
import pathlib
import sys

from plot_elements import grouped, plot, read


def main():
    folder = pathlib.Path(sys.argv[1])
    rows = [row for row in read("accuracy_integrators") if row["rung"].startswith("fem.time_step")]
    for quantity, what in (("position", "positions"), ("rotation", "microrotations")):
        column = f"{quantity}_error"
        good = [row for row in rows if math.isfinite(float(row[column]))]
        plot(folder / f"integrators_{quantity}_time.svg", f"Error of {what} against run time", "CPU seconds",
             "relative error", grouped(good, lambda r: r["integrator"], "cpu_s", column))
        plot(folder / f"integrators_{quantity}_step.svg", f"Error of {what} over the time step", "time step [s]",
             "relative error", grouped(good, lambda r: r["integrator"], "value", column))


if __name__ == "__main__":
    main()
