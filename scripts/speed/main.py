#!/usr/bin/env python3
"""How fast this is beside OpenCV, on this machine and, estimated, on a board.

Without --arm: the host's program times both in random turns in one process, with one thread and with two;
growth.png shows time over size and over candidates, and for each pixel and candidate. SCENE_DIR as in
scripts/evaluate (default: Cones and Teddy in $STOF_DATA/stereo, else the emulated corridor). Ten minutes at most; --quick takes one.

--arm: instructions of a frame as counted in qemu-user, ours and OpenCV's, and what a model of the
processors makes of the loops.

--page: the figures that were kept as tables between two marks in docs/PERFORMANCE.md.

Everything is kept in build/bench: speed.json and, of the run before, speed_before.json; arm.json, growth.png.
Every time is the least of all turns: CPU time of the thread, with two threads time by the clock.
"""

import argparse
import os
import pathlib
import subprocess
import sys

import arm
import table
from common import BENCH, ROOT, Trouble, run

USUAL = ("Cones", "Teddy")


def scenes_of(named):
    if named:
        for folder in named:
            if not (folder / "meta.txt").is_file():
                raise Trouble(f"{folder}: holds no meta.txt: name folders with left.pgm, right.pgm and meta.txt")
        return named
    data = os.environ.get("STOF_DATA")
    if not data:
        return []
    found = [pathlib.Path(data) / "stereo" / name for name in USUAL]
    return [folder for folder in found if (folder / "meta.txt").is_file()]


def host(options):
    scenes = scenes_of(options.scenes)
    out = (options.json or BENCH / ("quick.json" if options.quick else "speed.json")).resolve()
    if not out.parent.is_dir():
        raise Trouble(f"{out.parent}: no such folder: make it, or name another file")
    run("configure", "cmake", "--preset", "emu", "-Wno-dev", "-B", BENCH, "-DSTOF_BENCH=ON", "-DSTOF_TESTS=OFF")
    run("build", "cmake", "--build", BENCH, "--target", "stof_bench")
    if out.is_file():
        out.replace(out.with_stem(f"{out.stem}_before"))
    words = [BENCH / "bin/stof_bench", "--json", out, *(["--quick"] if options.quick else []), *scenes]
    if (code := subprocess.run(list(map(str, words)), check=False).returncode):
        raise Trouble(f"stof_bench ended with {code}")
    print(f"kept in {out}")
    if not options.quick:
        import plot  # draws, which takes a while to load
        plot.draw(out, BENCH / "growth.png")


class Parser(argparse.ArgumentParser):
    def error(self, message):
        raise Trouble(f"{message}: scripts/bench --help tells what there is")


def main():
    parser = Parser(prog="scripts/bench", description=__doc__,
                    formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="fewer rounds, without the largest size and growth")
    parser.add_argument("--json", type=pathlib.Path, metavar="FILE", help="where figures are kept")
    parser.add_argument("--arm", action="store_true", help="instructions and estimates for 64-bit ARM")
    parser.add_argument("--page", action="store_true", help="writes the tables in docs/PERFORMANCE.md")
    parser.add_argument("scenes", nargs="*", type=pathlib.Path, metavar="SCENE_DIR")
    options = parser.parse_args()
    if options.arm and (options.quick or options.scenes):
        parser.error("--arm counts on pictures of its own: leave --quick and scenes out")
    BENCH.mkdir(parents=True, exist_ok=True)
    if options.page:
        table.write(ROOT / "docs/PERFORMANCE.md", BENCH / "speed.json", BENCH / "speed_before.json", BENCH / "arm.json")
    elif options.arm:
        arm.go((options.json or BENCH / "arm.json").resolve())
    else:
        host(options)


if __name__ == "__main__":
    try:
        main()
    except Trouble as trouble:
        print(f"bench: {trouble}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        sys.exit(130)
