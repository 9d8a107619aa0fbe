#!/usr/bin/env python3
"""Draws mpm_semi_implicit.csv, made by bench_mpm_semi_implicit, as SVG for docs/mpm.md. Usage: plot_mpm_semi_implicit.py OUT_FOLDER"""

import math
import pathlib
import sys

from plot_elements import grouped, plot, read


def label(row):
    how = "explicit" if row["method"] == "explicit" else "semi-implicit, d = " + row["damping"]
    return f"{how}, {row['fibres']}"


def main():
    folder = pathlib.Path(sys.argv[1])
    rows = [row for row in read("mpm_semi_implicit") if math.isfinite(float(row["error"]))]
    shown = [row for row in rows if row["method"] == "explicit" or row["tolerance"] == "0.1"]
    plot(folder / "mpm_semi_implicit.svg", "Error against run time, fibres across or along the bar", "CPU seconds",
         "error over the amplitude", grouped(shown, label, "cpu_s", "error"))


if __name__ == "__main__":
    main()
