"""The tables in docs/PERFORMANCE.md."""

from common import ARM_FLOORS, FLOORS, Trouble, kept

BEGIN, END = "<!-- speed: begin (scripts/bench --page) -->", "<!-- speed: end -->"
SIZES = ("450x375x64", "640x480x64", "1280x720x128")
STEREO = ("WTA 15x15", "fast", "quality", "coarse to fine, 1", "coarse to fine, 2")


def first(results, group, name, threads=1):
    """The outcome of a contender, in the first group of that name."""
    return next((one for one in results if one["name"] == name and one["threads"] == threads
                 and one["group"].startswith(group)), None)


def row(runs, group, name, size, threads=1):
    """The later run's times; both runs' ratios, so that a reader sees how well they repeat."""
    both = [first(run["results"], group, name, threads) for run in runs]
    if any(one is None or "peer" not in one for one in both):
        return []
    one = both[0]
    ratio, time = ("cpu_ratio", "cpu_ms") if threads == 1 else ("ratio", "least_ms")
    peer = next(other for other in runs[0]["results"] if other["group"] == one["group"]
                and other["name"] == one["peer"] and other["threads"] == threads)
    floor = FLOORS.get((name, size))
    return [f"| {name} | {size} | {one[time]:.2f} | {one['peer']}: {peer[time]:.2f} | **{one[ratio]:.2f}** | "
            f"{both[1][ratio]:.2f} | {'' if floor is None else f'{floor:.2f}'} |"]


def host(runs):
    """The table of two runs, the later one first."""
    later = runs[0]
    lines = [f"On {later['machine']} ({later['vectors']}), beside {later['peer']}; {later['rounds']} turns each.", "",
             "| what | size | ms | peer, ms | ratio | run before | at most |",
             "| --- | --- | --- | --- | --- | --- | --- |"]
    for size in SIZES:
        for name in STEREO:
            lines += row(runs, size + ",", name, size)
    for name in ("WTA 15x15", "quality"):
        lines += row(runs, "640x480x64,", name, "640x480x64, two threads", threads=2)
    for size in ("176x144", "640x480"):
        lines += row(runs, f"PMD {size}", "phase", size)
    lines += row(runs, "rectify", "rectify", "two of 640x480")
    for name in ("convert and fuse", "whole frame"):
        lines += row(runs, "frame", name, "640x480x64, PMD 176x144")
    lines += row(runs, "temporal filter", "temporal filter", "640x480")
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


def write(page, speed, speed_before, instructions):
    text = page.read_text()
    if BEGIN not in text or END not in text:
        raise Trouble(f"{page}: lacks the marks of the table: add {BEGIN} and {END}")
    before, rest = text.split(BEGIN, 1)
    after = rest.split(END, 1)[1]
    runs = [kept(file, "scripts/bench twice") for file in (speed, speed_before)]
    body = [*host(runs), "", *arm(kept(instructions, "scripts/bench --arm"))]
    page.write_text(f"{before}{BEGIN}\n" + "\n".join(body) + f"\n{END}{after}")
    print(f"tables written to {page}")
