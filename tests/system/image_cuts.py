#!/usr/bin/env python3
"""tests/system/image_cuts.py [--points N]: power that goes during an update, and what then really boots.

Takes the card before and what the guest wrote to it from image_update.py --logs, which is run first where it has not been:
pairing, stof update, its confirmation, stof update --revert and its confirmation. Each point is a card with the writes up to
one of them, the last of them torn; boot_rom.py chooses the slot by it, the slot must hold the old or the new release byte for byte,
its kernel is started in QEMU, and the supervisor has to say that it is that slot: at every sixth point, and where settings were
written, also stofd, which release it is. A quarter of an hour for 60 points; not part of the test run.
"""

import argparse
import collections
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import block_log
import boot_rom
import checks
import initramfs
import machine

import disk  # of scripts/imaging, which initramfs names

ROOT = initramfs.ROOT
BOOT_S = 240
FAR_EVERY = 6
# number: writes before it that are on the medium. torn: bytes of that one; None: there is no other.
Point = collections.namedtuple("Point", "what number torn")


def part_of(offset):
    for part in disk.PARTITIONS:
        if part.begin <= offset < part.begin + part.size:
            name = part.name
            if part in disk.SLOTS.values() and offset >= part.begin + part.size - disk.RECORD:
                return "record"
            return "slot" if part in disk.SLOTS.values() else name
    return "table"


def points_of(writes, wanted):
    """Points at every write of the boot partition, of records and of settings, torn in several ways, and some of the content."""
    kinds = collections.defaultdict(list)
    for number, write in enumerate(writes):
        if write.bytes:
            kinds[part_of(write.offset)].append(number)
    points = []
    for what in ("boot", "record", "settings"):
        for number in kinds[what]:
            size = len(writes[number].bytes)
            tears = (0, 26, 33, 60, size // 2, size) if what == "boot" else (0, size // 2, size)
            points += [Point(what, number, torn) for torn in dict.fromkeys(min(torn, size) for torn in tears)]
    fixed = [point for point in points if point.what != "settings"]
    some = [point for point in points if point.what == "settings"]
    room = max(0, wanted - len(fixed))
    fixed += spread(some, room // 2)
    chunks = [Point("slot", number, len(writes[number].bytes) * k // 2) for k, number in enumerate(kinds["slot"] * 2)]
    chunks = [point._replace(torn=min(point.torn % (len(writes[point.number].bytes) + 1), len(writes[point.number].bytes)))
              for point in chunks]
    return sorted(fixed + spread(chunks, wanted - len(fixed)), key=lambda point: (point.number, point.torn))


def spread(items, count):
    return [items[k * len(items) // count] for k in range(min(count, len(items)))] if count > 0 else []


class Cards:
    """The card at each point, made of the one before."""

    def __init__(self, before, writes, work):
        self.rolling, self.cut = work / "rolling.img", work / "cut.img"
        self.writes, self.done = writes, 0
        copy(before, self.rolling)

    def at(self, point):
        with open(self.rolling, "r+b") as card:
            for write in self.writes[self.done:point.number]:
                card.seek(write.offset)
                card.write(write.bytes)
        self.done = max(self.done, point.number)
        copy(self.rolling, self.cut)
        write = self.writes[point.number]
        with open(self.cut, "r+b") as card:
            card.seek(write.offset)
            card.write(write.bytes[:point.torn])
        return self.cut


def copy(source, to):
    subprocess.run(["cp", "--sparse=always", "--reflink=auto", source, to], check=True)


def content(card, slot, size):
    with open(card, "rb") as file:
        file.seek(disk.SLOTS[slot].begin)
        return file.read(size)


def boots(card, whole, work, far):
    """Which release of which slot that card starts; it is one of those that are whole, {(slot, bytes): version}. far: until
    stofd has read settings and keys, and told its release; else until the supervisor runs."""
    slot = boot_rom.chosen(card, "all")
    found = [version for (of, data), version in whole.items() if of == slot and content(card, slot, len(data)) == data]
    checks.check(len(found) == 1, f"slot {slot} holds no whole release")
    boot, words = boot_rom.loaded(card, slot, work)
    with machine.Machine(*boot, command_line=words, drive=card, serial=False, processors=1,
                         log=work / "console.log") as guest:
        guest.go()
        guest.console.plain(f"slot {slot}, kernel", timeout=BOOT_S)
        if not far:
            return slot, found[0]
        line = guest.console.plain(r"release \S+ in slot", timeout=BOOT_S)
        said = re.search(r"release (\S+) in slot (\S)( on trial)?", line)
        checks.check((said[2], said[3]) == (slot, None), f"it started {line!r}")
        checks.check(said[1] == found[0], f"slot {slot} holds {found[0]}, and says {line!r}")
        checks.check(not any("cannot be read" in other for other in guest.console.other), "settings or keys are lost")
    return slot, found[0]


def run(options):
    source = pathlib.Path(options.update)
    if not (source / "before.img").exists():
        subprocess.run([ROOT / "tests/system/image_update.py", "--logs", "--case", "updated", "--case", "reverted", "--work",
                        source], check=True)
    work = pathlib.Path(options.work)
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    report = checks.Report()
    # Of the start that took the update, of the one on trial, which was confirmed and reverted, and of the one after that.
    logs = [[write for write in block_log.read(source / f"writes_{start}") if write.bytes] for start in range(3)]
    until, writes = len(logs[0]) + len(logs[1]), [write for log in logs for write in log]
    # What the slots hold when they are whole: before, and when the update is confirmed.
    last = Cards(source / "before.img", writes, work).at(Point("end", until, 0))
    versions = dict(zip(("before", "after"), (options.old or old_version(source / "before.img"), "two")))
    whole = {("a", content(source / "before.img", "a", used(source / "before.img", "a"))): versions["before"],
             ("b", content(last, "b", used(last, "b"))): versions["after"]}
    cards = Cards(source / "before.img", writes, work)
    points = points_of(writes, options.points)
    seen = collections.Counter()
    for k, point in enumerate(points):
        name = f"point {k}: write {point.number} of {len(writes)}, {point.what}, {point.torn} of {len(writes[point.number].bytes)} bytes"
        started = []
        begin = time.monotonic()
        far = point.what == "settings" or k % FAR_EVERY == 0
        if report.run(name, lambda point=point, far=far: started.append(boots(cards.at(point), whole, work, far))):
            seen[started[0]] += 1
            print(f"  starts release {started[0][1]} in slot {started[0][0]}, {time.monotonic() - begin:.1f} s", flush=True)
    report.figure("points that booted the old or the new release", report.passed, f">= {options.points}", report.passed >= options.points)
    for (slot, version), count in sorted(seen.items()):
        print(f"  slot {slot}, release {version}: {count}")
    print(f"{report.passed} passed, {report.failed} failed")
    return 1 if report.failed or report.passed < options.points else 0


def record_of(card, slot):
    with open(card, "rb") as file:
        file.seek(disk.SLOTS[slot].begin + disk.SLOTS[slot].size - disk.RECORD)
        return file.read(disk.RECORD)


def old_version(card):
    return record_of(card, "a")[48:80].rstrip(b"\0").decode()


def used(card, slot):
    """Bytes of the release in a slot, as its record says."""
    return int.from_bytes(record_of(card, slot)[84:88], "little")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=60)
    parser.add_argument("--update", default=ROOT / "build/system/update", help="folder of image_update.py --logs")
    parser.add_argument("--work", default=ROOT / "build/system/cuts")
    parser.add_argument("--old", help="version of the release before (default: as the card says)")
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    return run(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
