#!/usr/bin/env python3
"""scripts/budgets.py BUILD [BUILD...]: whether a board's program stays within its budgets.

Judges BUILD/bin/stofd, a 64-bit ARM file, by scripts/budgets.json, which has for every board ("*"), or for one by
its name, what text (code and constants), bss and data may take, and the largest frame of any of our functions on
the stack; that is read from the .su files that -fstack-usage leaves. A program for a board is one
static file: it names no loader and needs no library. Prints a line for each figure, and ends with
code 1 when one of them is over, or when there is nothing to judge.
"""

import json
import pathlib
import re
import struct
import sys

BUDGETS = pathlib.Path(__file__).with_name("budgets.json")
KIB = 1024
DELIBERATE = "prefault_stack"  # takes stack so that others find it in RAM
PT_LOAD, PT_DYNAMIC, PT_INTERP = 1, 2, 3
PF_WRITE = 2
ARM64 = 183


def segments(program):
    """[(type, flags, bytes in the file, bytes in memory)] of a little-endian 64-bit ELF file."""
    data = program.read_bytes()
    if data[:6] != b"\x7fELF\x02\x01" or struct.unpack_from("<H", data, 18)[0] != ARM64:
        raise ValueError(f"{program}: not a 64-bit ARM program: build it with the board's preset")
    offset, = struct.unpack_from("<Q", data, 32)
    size, count = struct.unpack_from("<HH", data, 54)
    found = []
    for index in range(count):
        kind, flags, _, _, _, in_file, in_memory, _ = struct.unpack_from("<IIQQQQQQ", data, offset + index * size)
        found.append((kind, flags, in_file, in_memory))
    return found


def sizes(program):
    """{"text": bytes, "data": bytes, "bss": bytes} of a static program."""
    parts = segments(program)
    if any(kind in (PT_INTERP, PT_DYNAMIC) for kind, *_ in parts):
        raise ValueError(f"{program}: needs a loader or libraries: link it with -static")
    loaded = [part for part in parts if part[0] == PT_LOAD]
    writable = [part for part in loaded if part[1] & PF_WRITE]
    return {
        "text": sum(part[3] for part in loaded if not part[1] & PF_WRITE),
        "data": sum(part[2] for part in writable),
        "bss": sum(part[3] - part[2] for part in writable),
    }


def largest_frame(build):
    """(bytes, function) of our function that takes the most stack; unbounded ones count as endless.

    What is made of a library's headers is the library's: Eigen's alloca is bounded by its 3x3 matrices.
    """
    worst = (0, "")
    for file in build.rglob("*.su"):
        for line in file.read_text(errors="replace").splitlines():
            place, size, kind = line.rsplit("\t", 2)
            if "/usr/include/" in place or DELIBERATE in place:
                continue
            size = float("inf") if kind == "dynamic" else int(size)
            worst = max(worst, (size, place))
    return worst


def judge(build, budgets):
    """[(line, within)] of one build."""
    board = re.search(r"^STOF_BOARD:STRING=(.*)$", (build / "CMakeCache.txt").read_text(), re.MULTILINE)[1]
    budget = budgets.get("*", {}) | budgets.get(board, {})
    taken = sizes(build / "bin" / "stofd")
    lines = []
    for part in ("text", "data", "bss"):
        limit = budget[f"{part}_kib"] * KIB
        lines.append((f"{board} {part}: {taken[part] / KIB:.0f} KiB of {budget[f'{part}_kib']}", taken[part] <= limit))
    frame, place = largest_frame(build)
    lines.append((f"{board} largest stack frame: {frame} of {budget['frame_bytes']} bytes, {place}",
                  0 < frame <= budget["frame_bytes"]))
    return lines


def main():
    builds = [pathlib.Path(name) for name in sys.argv[1:]]
    if not builds:
        sys.exit("scripts/budgets.py BUILD [BUILD...]: name the folder of a board's build, such as build/virt")
    budgets = json.loads(BUDGETS.read_text())
    over = 0
    for build in builds:
        try:
            lines = judge(build, budgets)
        except (OSError, ValueError, KeyError, TypeError) as error:
            lines = [(f"{build}: {error}", False)]
        for line, within in lines:
            print(line if within else f"{line}: OVER, or not known: make it smaller, or say why it is larger")
            over += not within
    return 1 if over else 0


if __name__ == "__main__":
    sys.exit(main())
