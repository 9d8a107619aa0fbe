#!/usr/bin/env python3
"""Draws cantilever.csv, the measures of shots/cantilever.toml over time, as SVG: the curves of Fig. 3 of Loeschner et al.
2023, for docs/micropolar.md. Usage: plot_cantilever.py OUT_FOLDER"""

import pathlib
import sys

from plot_elements import plot, read


def main():
    folder = pathlib.Path(sys.argv[1])
    rows = read("cantilever")

    def curve(column, factor=1.0):
        return [(float(row["time_s"]), factor * float(row[column])) for row in rows]

    def draw(name, title, ylabel, series, **more):
        plot(folder / f"cantilever_{name}.svg", title, "time [s]", ylabel, series, logx=False, logy=False, **more)

    draw("twist", "Largest twist between nodes of an element", "degrees",
         {"this shot": curve("twist_deg")}, reference=31.0)
    draw("distance", "Microrotation against macrorotation, mean", "degrees",
         {"at quadrature points": curve("distance_at_points_deg"), "at element centroids": curve("distance_at_centroids_deg"),
          "at nodes": curve("distance_at_nodes_deg")}, reference=2.62)
    draw("wryness", "Largest relative error of the wryness", "%",
         {"interpolated velocities": curve("curvature_error", 100.0)}, reference=0.8)
    draw("interpolation", "Largest error of interpolated rotations", "degrees",
         {"rotation vectors": curve("vector_error_deg"), "interpolated velocities": curve("velocity_error_deg"),
          "quaternion blend": curve("blend_error_deg")})


if __name__ == "__main__":
    main()
