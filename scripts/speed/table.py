"""The table in README.md."""

from common import ARM_FLOORS, FLOORS, Trouble, kept

BEGIN, END = "<!-- speed: begin (scripts/bench --readme) -->", "<!-- speed: end -->"
SIZES = ("450x375x64", "640x480x64", "1280x720x128")
STEREO = ("WTA 15x15", "fast", "quality", "coarse to fine, 1", "coarse to fine, 2")


def first(results, group, name, threads=1):
    """The outcome of a contender, in the first group of that name."""
    return next((one for one in results if one["name"] == name and one["threads"] == threads
                 and one["group"].startswith(group)), None)


def row(results, group, name, size, threads=1):
    one = first(results, group, name, threads)
    if one is None or "peer" not in one:
        return []
    ratio = "cpu_ratio" if threads == 1 else "ratio"
    time = "cpu_ms" if threads == 1 else "median_ms"
    peer = next(other for other in results if other["group"] == one["group"] and other["name"] == one["peer"]
                and other["threads"] == threads)
    floor = FLOORS.get((name, size))
    return [f"| {name} | {size} | {one[time]:.2f} | {one['peer']}: {peer[time]:.2f} | **{one[ratio]:.2f}** | "
            f"{'' if floor is None else f'{floor:.2f}'} |"]


def host(figures):
    results = figures["results"]
    lines = ["| what | size | ms | peer, ms | ratio | at most |", "| --- | --- | --- | --- | --- | --- |"]
    for size in SIZES:
        for name in STEREO:
            lines += row(results, size + ",", name, size)
    for name in ("WTA 15x15", "quality"):
        lines += row(results, "640x480x64,", name, "640x480x64, two threads", threads=2)
    for size in ("176x144", "640x480"):
        lines += row(results, f"PMD {size}", "phase", size)
    lines += row(results, "rectify", "rectify", "two of 640x480")
    for name in ("convert and fuse", "whole frame"):
        lines += row(results, "frame", name, "640x480x64, PMD 176x144")
    return lines


def arm(figures):
    names = figures["processors"]
    heads = [f"{name}, ms" for name in names]
    lines = [f"| 64-bit ARM, 640x480x64 | million instructions | of StereoBM's | at most | {' | '.join(heads)} |",
             "| --- | --- | --- | --- |" + " --- |" * len(names)]
    for one in figures["results"]:
        times = " | ".join(f"{one[name]['ms']:.2f}" for name in names)
        floor = ARM_FLOORS.get(one["task"])
        share = f"{one['of_stereo_bm']:.2f}"
        lines.append(f"| {one['what']} | {one['instructions'] / 1e6:.1f} | {share} | "
                     f"{'' if floor is None else f'{floor:.2f}'} | {times} |")
    return lines


def write(readme, speed, instructions):
    text = readme.read_text()
    if BEGIN not in text or END not in text:
        raise Trouble(f"{readme}: lacks the marks of the table: add {BEGIN} and {END}")
    before, rest = text.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    figures = kept(speed, "scripts/bench")
    body = [*host(figures), "", *arm(kept(instructions, "scripts/bench --arm"))]
    readme.write_text(f"{before}{BEGIN}\n" + "\n".join(body) + f"\n{END}{after}")
    print(f"table written to {readme}")
