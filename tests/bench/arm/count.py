#!/usr/bin/env python3
"""count.py --program stof_count --plugin count.so --sysroot DIR [--update]: has a kernel become more expensive?

Counts the instructions of each task and of the functions that take most of it, in qemu-user, and compares
them with instructions.json beside this file. Ends with 1 when one takes more than 3 percent more than is
stored, with 77 (skipped) where nothing can be counted. --update stores what was counted; to do so after
a change that is worth it:

    cmake --preset arm64 && cmake --build build/arm64 --target stof_count
    tests/bench/arm/count.py --update
"""

import argparse
import json
import pathlib
import sys

import counting

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
BUILD = ROOT / "build" / "arm64"
STORED = HERE / "instructions.json"
SKIPPED = 77
ALLOWED = 1.03
DOMINATING = 0.04  # of a task: functions that are stored by name
SUMS = ("frame",)  # what is counted in other tasks
UPDATE = "tests/bench/arm/count.py --update"


def measure(program, plugin, sysroot):
    """{task: {"total": instructions, function: instructions}}, the functions that dominate alone."""
    tasks = [task for task in counting.tasks_of(program, sysroot) if task not in SUMS]
    functions = counting.Functions(program)
    found = {}
    for task, blocks in sorted(counting.per_task(program, plugin, sysroot, tasks).items()):
        whole = counting.total(blocks)
        parts = functions.counts(blocks).most_common()
        found[task] = {"total": whole, **{name: count for name, count in parts if count >= DOMINATING * whole}}
    return found


def judge(found, stored):
    """(lines about what grew, lines about the rest)."""
    grown = [f"{task}: is stored and was not counted: run {UPDATE}" for task in stored if task not in found]
    notes = []
    for task, counts in found.items():
        before = stored.get(task)
        if before is None:
            grown.append(f"{task}: nothing is stored for it: run {UPDATE}")
            continue
        for name, count in counts.items():
            if name not in before:
                notes.append(f"{task}: {name} takes {count} instructions and is not stored: run {UPDATE}")
            elif count > ALLOWED * before[name]:
                grown.append(f"{task}: {name} takes {count} instructions, {100 * (count / before[name] - 1):.1f} percent "
                             f"more than the {before[name]} stored: make it cheaper, or store this: {UPDATE}")
            elif count < before[name] / ALLOWED:
                notes.append(f"{task}: {name} takes {100 * (1 - count / before[name]):.1f} percent less than stored: "
                             f"keep that: {UPDATE}")
    return grown, notes


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=BUILD / "bin/stof_count")
    parser.add_argument("--plugin", type=pathlib.Path, default=BUILD / "tests/bench/arm/count.so")
    parser.add_argument("--sysroot", type=pathlib.Path, default=ROOT / "build/sysroot-arm64")
    parser.add_argument("--stored", type=pathlib.Path, default=STORED)
    parser.add_argument("--update", action="store_true", help="store what is counted")
    options = parser.parse_args()
    try:
        found = measure(options.program, options.plugin.resolve(), options.sysroot)
    except counting.CannotCount as reason:
        print(f"skipped: {reason}")
        return 2 if options.update else SKIPPED
    if options.update:
        options.stored.write_text(json.dumps(found, indent=1) + "\n")
        print(f"{len(found)} tasks stored in {options.stored}")
        return 0
    stored = json.loads(options.stored.read_text()) if options.stored.is_file() else {}
    grown, notes = judge(found, stored)
    print("\n".join(notes + grown))
    compared = sum(map(len, found.values()))
    print(f"{compared} counts compared, {len(grown)} too high")
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main())
