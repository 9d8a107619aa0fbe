#!/usr/bin/env python3
"""Draws errors_*.csv, made by errors.sh, as SVG for docs/evidence.md. Usage: plot_errors.py OUT_FOLDER"""

import math
import pathlib
import sys

from plot_elements import plot, read


def series(rows, time, columns):
    """One line of (time, error) per named column, without what is no number."""
    lines = {}
    for column, label in columns.items():
        points = [(float(row[time]), float(row[column])) for row in rows if column in row]
        lines[label] = [(x, y) for x, y in points if math.isfinite(y) and y > 0.0]
    return {label: points for label, points in lines.items() if points}


def main():
    folder = pathlib.Path(sys.argv[1])
    plot(folder / "errors_contact.svg", "Hertz: contact radius of a ball", "CPU seconds", "relative error",
         series(read("errors_contact"), "cpu_s", {"error": "4, 8, 12, 16 cells"}))
    measures = {
        "run_out_x_error": "run-out along x",
        "pile_height_error": "height of the pile",
        "energy_error": "energy",
        "density_error": "density",
    }
    plot(folder / "errors_column_cell.svg", "Column: cells of 33 to 14 mm against 10 mm", "CPU seconds", "relative error",
         series(read("errors_column_cell"), "cpu_s", measures))
    plot(folder / "errors_column_ppc.svg", "Column: 1 to 8 particles per cell against 27", "CPU seconds",
         "relative error", series(read("errors_column_ppc"), "cpu_s", measures))
    grains = [row for row in read("errors_grains") if float(row["travel_cells"]) > 0.0]
    plot(folder / "errors_grains.svg", "Grains brought up to date less often", "microseconds per grain and step",
         "error in cells", series(grains, "us_per_grain_and_step",
                                  {"median_error_cells": "median", "error_of_99_percent_cells": "99 %"}))
    plot(folder / "errors_samples.svg", "Pictures of 1 to 64 sub-frames against 256", "CPU seconds a picture",
         "RMS of linear light", series(read("errors_samples"), "cpu_s", {"picture_error": "bunny, 960 x 540"}))


if __name__ == "__main__":
    main()
