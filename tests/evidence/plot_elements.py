#!/usr/bin/env python3
"""Draws the tables elements_*.csv of this folder as SVG, for docs/elements.md. Usage: plot_elements.py OUT_FOLDER"""

import csv
import math
import pathlib
import sys

HERE = pathlib.Path(__file__).parent
COLOURS = ["#1f6fb4", "#d1495b", "#2e933c", "#8a5fbf", "#e08e0b", "#444444"]


def read(name):
    lines = (HERE / f"{name}.csv").read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def ticks(low, high, log):
    if log:
        return [10.0**k for k in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)]
    step = 10.0 ** math.floor(math.log10((high - low) / 4))
    step *= next(m for m in (1, 2, 5, 10) if (high - low) / (m * step) <= 6)
    return [step * k for k in range(math.floor(low / step), math.ceil(high / step) + 1)]


def plot(path, title, xlabel, ylabel, series, logx=True, logy=True, reference=None):
    """series: {label: [(x, y), ...]}; reference: a level line."""
    width, height, left, right, top, bottom = 700, 400, 78, 215, 40, 56
    xs = [x for points in series.values() for x, _ in points]
    ys = [y for points in series.values() for _, y in points] + ([reference] if reference is not None else [])
    xticks, yticks = ticks(min(xs), max(xs), logx), ticks(min(ys), max(ys), logy)

    def place(value, marks, log, begin, end):
        f = math.log10 if log else float
        return begin + (f(value) - f(marks[0])) / (f(marks[-1]) - f(marks[0])) * (end - begin)

    def at(x, y):
        return place(x, xticks, logx, left, width - right), place(y, yticks, logy, height - bottom, top)

    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="13">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        f'<text x="{left}" y="22" font-size="15" font-weight="bold">{title}</text>',
    ]
    for x in xticks:
        px = at(x, yticks[0])[0]
        out.append(f'<line x1="{px:.1f}" y1="{top}" x2="{px:.1f}" y2="{height - bottom}" stroke="#ddd"/>')
        out.append(f'<text x="{px:.1f}" y="{height - bottom + 18}" text-anchor="middle">{x:g}</text>')
    for y in yticks:
        py = at(xticks[0], y)[1]
        out.append(f'<line x1="{left}" y1="{py:.1f}" x2="{width - right}" y2="{py:.1f}" stroke="#ddd"/>')
        out.append(f'<text x="{left - 8}" y="{py + 4:.1f}" text-anchor="end">{y:g}</text>')
    if reference is not None:
        py = at(xticks[0], reference)[1]
        out.append(f'<line x1="{left}" y1="{py:.1f}" x2="{width - right}" y2="{py:.1f}" stroke="#888" stroke-dasharray="5 4"/>')
    for number, (label, points) in enumerate(series.items()):
        colour = COLOURS[number % len(COLOURS)]
        line = " ".join("{:.1f},{:.1f}".format(*at(x, y)) for x, y in points)
        out.append(f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="2"/>')
        for x, y in points if len(points) <= 40 else []:
            out.append('<circle cx="{:.1f}" cy="{:.1f}" r="3.5" fill="{}"/>'.format(*at(x, y), colour))
        out.append(f'<text x="{width - right + 12}" y="{top + 16 + 19 * number}" fill="{colour}">{label}</text>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 14}" text-anchor="middle">{xlabel}</text>')
    middle = (top + height - bottom) / 2
    out.append(f'<text x="18" y="{middle}" text-anchor="middle" transform="rotate(-90 18 {middle})">{ylabel}</text>')
    path.write_text("\n".join(out + ["</svg>", ""]))


def grouped(rows, label, x, y):
    series = {}
    for row in rows:
        series.setdefault(label(row), []).append((float(row[x]), float(row[y]) if isinstance(y, str) else y(row)))
    return series


def main():
    folder = pathlib.Path(sys.argv[1])
    bending = read("elements_bending")
    plot(folder / "elements_bending.svg", "Bending of a bar: error against time", "CPU seconds of the solve",
         "relative error of the deflection",
         grouped(bending, lambda r: r["element"], "cpu_s", lambda r: abs(float(r["deflection_ratio"]) - 1)))
    rows = [r for r in read("elements_plate_locking") if r["cells"] in ("8", "32")]
    plot(folder / "elements_plate_locking.svg", "Plates: deflection over the closed form", "thickness over length",
         "ratio", grouped(rows, lambda r: f'{r["element"]}, {r["cells"]} cells', "thickness", "deflection_ratio"),
         reference=1.0)
    plot(folder / "elements_couple_modulus.svg", "A large couple modulus locks linear tets", "mu_c / mu",
         "deflection over the closed form",
         grouped(read("elements_couple_modulus"), lambda r: f'{r["element"]}, {r["cells"]} across',
                 "couple_modulus_ratio", "deflection_ratio"), logy=False)
    hourglass = read("elements_hourglass")
    plot(folder / "elements_hourglass.svg", "Roughness of the rotations after a random spin", "time [s]",
         "neighbours apart, rms [rad]",
         {name: [(float(r["time_s"]), float(r[key])) for r in hourglass]
          for name, key in (("one point", "one_point_roughness_rad"), ("four points", "four_points_roughness_rad"))})
    if (HERE / "elements_det_volume.csv").exists():
        plot(folder / "elements_det_volume.svg", "Stretch of a clamped bar: energy, coarse over fine", "stretch",
             "coarse / fine", grouped(read("elements_det_volume"), lambda r: f'{r["model"]}, nu {r["poisson_ratio"]}',
                                      "stretch", "coarse_over_fine"), logx=False, logy=False)
    if (HERE / "elements_twist.csv").exists():
        plot(folder / "elements_twist.svg", "Twist of a bar: microrotation against the matter", "turns",
             "mean distance [degrees]", grouped(read("elements_twist"), lambda r: r["model"], "turns",
                                                "mean_distance_deg"), logx=False, logy=False)


if __name__ == "__main__":
    main()
