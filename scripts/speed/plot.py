"""Time over the size of the picture and over the number of candidates, with the straight line nearest to it; and
the time for each pixel and candidate, with one thread and with two."""

import re

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as pyplot  # noqa: E402
import numpy  # noqa: E402

from common import kept  # noqa: E402

SIZE = re.compile(r"(growth|together) (\d+)x(\d+)x(\d+)")
USUAL_PIXELS, USUAL_CANDIDATES = 640 * 480, 64


def curves(results, kind, threads=1):
    """{name: [(pixels, candidates, ms)]}; by the clock where there are several threads."""
    found = {}
    for one in results:
        match = SIZE.match(one["group"])
        if match and match[1] == kind and one["threads"] == threads:
            width, height, candidates = map(int, match.groups()[1:])
            time = one["cpu_ms"] if threads == 1 else one["least_ms"]
            found.setdefault(one["name"], []).append((width * height, candidates, time))
    return found


def fit(xs, ys):
    """(intercept, slope, the largest distance from the line as a share of what the line says)."""
    xs, ys = numpy.array(xs, float), numpy.array(ys, float)
    # By relative distance: a small picture's time counts as much as a large one's.
    matrix = numpy.stack([1 / ys, xs / ys], axis=1)
    (intercept, slope), *_ = numpy.linalg.lstsq(matrix, numpy.ones_like(ys), rcond=None)
    line = intercept + slope * xs
    return intercept, slope, float(numpy.max(numpy.abs(ys - line) / line))


def panel(axes, name, points, label):
    points = sorted(points)
    xs, ys = [x for x, _ in points], [y for _, y in points]
    intercept, slope, residual = fit(xs, ys)
    dots = axes.plot(xs, ys, "o", markersize=4)[0]
    axes.plot([0, xs[-1]], [intercept, intercept + slope * xs[-1]], color=dots.get_color(), linewidth=1,
              label=f"{name}: within {100 * residual:.0f} %")
    print(f"  {name:<16} over {label:<10} {intercept:7.2f} ms + {slope:.3g} ms each, the points within "
          f"{100 * residual:.1f} % of it")


def panel_of_each(axes, results):
    """Nanoseconds for each pixel and candidate where both grow together."""
    print("nanoseconds for each pixel and candidate:")
    colours = {}
    for threads, style in ((1, "o-"), (2, "s--")):
        for name, points in curves(results, "together", threads).items():
            xs = [pixels / 1e6 for pixels, _, _ in sorted(points)]
            ys = [1e6 * ms / (pixels * candidates) for pixels, candidates, ms in sorted(points)]
            label = f"{name}, {threads} thread{'s' if threads > 1 else ''}"
            dots = axes.plot(xs, ys, style, markersize=4, linewidth=1, color=colours.get(name), label=label)[0]
            colours[name] = dots.get_color()
            print(f"  {label:<28} " + "  ".join(f"{y:.3f}" for y in ys))
    axes.set_xlabel("megapixels, 32 to 128 candidates")
    axes.set_ylabel("ns for each pixel and candidate")


def draw(file, png):
    figure, (left, right, each) = pyplot.subplots(1, 3, figsize=(16.5, 4.2), dpi=110)
    results = kept(file, "scripts/bench")["results"]
    print("growth, a straight line:")
    for name, points in curves(results, "growth").items():
        by_size = [(pixels / 1e6, ms) for pixels, candidates, ms in points if candidates == USUAL_CANDIDATES]
        by_candidates = [(candidates, ms) for pixels, candidates, ms in points if pixels == USUAL_PIXELS]
        if min(len(by_size), len(by_candidates)) >= 3:
            panel(left, name, by_size, "megapixels")
            panel(right, name, by_candidates, "candidates")
    panel_of_each(each, results)
    left.set_xlabel(f"megapixels, {USUAL_CANDIDATES} candidates")
    right.set_xlabel("candidates, 640x480")
    for axes in (left, right):
        axes.set_ylabel("ms, one thread")
    for axes in (left, right, each):
        axes.set_xlim(left=0)
        axes.set_ylim(bottom=0)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(png)
    print(f"drawn in {png}")
