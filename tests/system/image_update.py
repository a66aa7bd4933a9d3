#!/usr/bin/env python3
"""tests/system/image_update.py: the image that is flashed, updated in QEMU: by stof update to slot B, back, and to releases that fail.

Flashes the image of scripts/image virt to a file, pairs with the label's code over the network, and then
- stof update: slot B runs on trial, publishes for 30 s, is confirmed, and any start takes it;
- stof update --revert: slot A in the same way;
- releases whose stofd ends at once, hangs before its first line, or whose kernel panics: left, and frames come again.
boot_rom.py stands for the boot ROM. Eight minutes.
"""

import argparse
import gzip
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import boot_rom
import checks
import image_boot
import initramfs
import machine
import rig as system_rig

import cpio  # of scripts/imaging, which initramfs names
import disk
import update_file

ROOT = initramfs.ROOT
LEAVE_BAR_S = 90
PROVEN_S = 400  # an upload into an emulated machine, a restart, half a minute of frames
# What stands in place of stofd in a release that fails.
FAILING = {
    "ends at once": "exit 1",
    "hangs before stofd": "while :; do usleep 1000000; done",
}


class Maker:
    """Releases of a slot's content, signed with the developer's key of this folder."""

    def __init__(self, image, work):
        self.slot = work / "slot.img"
        with open(image, "rb") as file:
            file.seek(disk.SLOTS["a"].begin)
            self.slot.write_bytes(file.read(disk.SLOTS["a"].size))
        with open(self.slot, "r+b") as file:  # the record is no part of the content
            file.seek(-disk.RECORD, os.SEEK_END)
            file.write(bytes(disk.RECORD))
        self.work = work
        self.key = update_file.Key.developers(ROOT / "build" / "update_key")

    def release(self, version, files=None):
        """An update file of the slot, with other files in place of some of its own: {name: bytes}."""
        slot = self.work / "changed.img"
        shutil.copyfile(self.slot, slot)
        for name, data in (files or {}).items():
            source = self.work / name
            source.write_bytes(data)
            disk.run(["mdel", "-i", slot, f"::{name}"])
            disk.run(["mcopy", "-i", slot, source, f"::{name}"])
        content = disk.used_part(slot)
        place = b"stof.slot=a"
        checks.check(content.count(place) == 1, "the letter of the slot is not there once")
        out = self.work / f"{version}.update"
        out.write_bytes(update_file.make(content, self.key, board="virt", camera="usb", version=version, counter=1,
                                         letter_at=content.index(place) + len(place) - 1)[0])
        return out

    def with_stofd(self, version, program):
        """Another program in place of stofd: a second archive behind the first one."""
        archive = cpio.Archive()
        archive.file("bin/stofd", program, 0o755)
        first = disk.run(["mtype", "-i", self.slot, "::initramfs"])
        return self.release(version, {"initramfs": first + bytes(-len(first) % 4) + gzip.compress(archive.bytes(), mtime=0)})


def put_into_slot(card, slot, file):
    """A release as a sensor leaves it in a slot; an upload into an emulated machine takes minutes."""
    data = bytearray(file.read_bytes())
    head = data[:update_file.HEAD_BYTES]
    size, letter_at = update_file.HEAD.unpack_from(head)[8:10]
    content = data[-size:]
    content[letter_at] = ord(slot)
    part = disk.SLOTS[slot]
    with open(card, "r+b") as disk_file:
        disk_file.seek(part.begin)
        disk_file.write(content)
        disk_file.seek(part.begin + part.size - disk.RECORD)
        disk_file.write(head.ljust(disk.RECORD, b"\0"))


def failing(maker):
    """[(what it does, what makes it)]: releases that have to be left."""
    releases = [(what, lambda text=text: maker.with_stofd("fails", f"#!/bin/sh\n{text}\n".encode())) for what, text in FAILING.items()]
    return [*releases, ("panics", lambda: maker.release("panics", {"initramfs": b"no archive"}))]


class Owner:
    """Who holds a key of the sensor: the real stof, from this machine."""

    def __init__(self, programs, work, board):
        self.stof = pathlib.Path(programs) / "stof"
        self.place = f"127.0.0.1:{board.host_port}"
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(work / "config")}

    def run(self, *words, timeout=PROVEN_S + 60):
        done = subprocess.run([self.stof, *map(str, words)], env=self.environment, capture_output=True, text=True,
                              check=False, timeout=timeout)
        print("  stof " + " ".join(map(str, words[:2])) + ": " + (done.stdout + done.stderr).strip().replace("\n", "\n  "), flush=True)
        return done

    def update(self, file):
        return self.run("update", self.place, file, "--wait", PROVEN_S, "--patience", 60, "--timeout", 5)


def frames_come(rig, report, what):
    """Ten frames, bit by bit those of their edges."""
    rig.receiver.wait(lambda frame: frame["missing"] == 0 and frame["depth"], timeout=120, what=f"frame of {what}")
    for _ in range(image_boot.FRAMES):
        rig.receiver.wait(lambda frame: frame["missing"] == 0 and frame["sensors"] == system_rig.BOTH, rig.receiver.count(),
                          timeout=60, what="next frame of both sensors")
    verdict = rig.judge(rig.receiver.frames)
    report.none(f"{what}: frames that differ from the host's", verdict["different"])


def is_settled(board, slot, report):
    found = [boot_rom.chosen(board.card, section) for section in ("all", "tryboot")]
    wanted = [slot, "b" if slot == "a" else "a"]
    report.figure("slots of a usual start and of one on trial", found, wanted, found == wanted)


def is_confirmed(board, number, slot, done, report):
    """That start was on trial and is confirmed."""
    begin = board.wait_for_start(number)[0]
    report.figure("start", begin, (slot, "tryboot"), begin == (slot, "tryboot"))
    report.figure("stof update ended with", done.returncode, "0, confirmed", done.returncode == 0 and "confirmed" in done.stdout)
    is_settled(board, slot, report)


def is_left(board, owner, file, report, what):
    """A release that fails: tried, left by a restart, and the former one publishes again."""
    slot = board.starts[-1][0]
    other = "b" if slot == "a" else "a"
    before = len(board.starts) + 1
    board.power_cut(lambda card: put_into_slot(card, other, file))
    frames_come(board.wait_for_start(before - 1)[1], report, "the former release")
    done = owner.run("update", "--revert", "--no-wait", owner.place, "--timeout", 5)
    checks.check(done.returncode == 0, "the release was not taken")
    begin, _ = board.wait_for_start(before)
    at = time.monotonic()
    checks.check(begin == (other, "tryboot"), f"it started {begin}")
    begin, rig = board.wait_for_start(before + 1)
    checks.check(begin == (slot, "all"), f"then it started {begin}")
    report.figure(f"{what}: start on trial to the next start", f"{time.monotonic() - at:.0f} s", "told: this machine may be busy", True)
    times = [float(found[1]) for found in (re.match(r"stof ([\d.]+): (slot|restart)", line) for line in board.said(before)) if found]
    if len(times) > 1:  # a kernel that panics comes to none
        report.at_most(f"{what}: until it is left, guest time", times[-1] - times[0], LEAVE_BAR_S, "s")
    frames_come(rig, report, f"the former release, after one that {what}")
    is_settled(board, slot, report)


def told(board):
    """What each start said last."""
    for number, start in enumerate(board.starts):
        print(f"  start {number}, {start}:\n    " + "\n    ".join(board.said(number)[-14:]))


def begun(options):
    """The folder of the work, empty; the report; the scenes; the image of scripts/image virt."""
    work = pathlib.Path(options.work)
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    scene = system_rig.Scene(options.programs, work.parent / "scenes")
    image = work / "virt.img"
    subprocess.run([ROOT / "scripts" / "image", "virt", "--out", image], check=True)
    return work, checks.Report(), scene, image


def file_of_code(said, work):
    """With the label's code that scripts/flash said."""
    code = work / "code"
    code.write_text(re.search(r"^((?:[0-9a-f]{4}-){7}[0-9a-f]{4})$", said, re.MULTILINE)[1].replace("-", ""))
    return code


def ended(report):
    """Prints the last line; the exit code."""
    print(f"{report.passed} passed, {report.failed} failed")
    return 1 if report.failed or not report.passed else 0


def arguments(doc, name):
    """What the programs about the image take. SIGTERM ends them from now on."""
    parser = argparse.ArgumentParser(description=doc.splitlines()[0])
    parser.add_argument("--programs", default=ROOT / "build/emu/bin", help="this machine's stof, stofd and test programs")
    parser.add_argument("--work", default=ROOT / "build/system" / name)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    return parser


def run(options):
    work, report, scene, image = begun(options)
    maker = Maker(image, work)
    port, card = machine.free_udp_port(), work / "card.img"
    code = file_of_code(image_boot.flashed(image, card, port, "dhcp", "--calibration", scene.calibration), work)
    if options.logs:
        shutil.copyfile(card, work / "before.img")
    with boot_rom.Board(scene, card, work, port, options.logs) as board:
        owner = Owner(options.programs, work, board)

        def first_start():
            begin, rig = board.wait_for_start(0)
            checks.check(begin == ("a", "all"), f"it started {begin}")
            frames_come(rig, report, "slot a")
            done = owner.run("pair", owner.place, "--code", f"@{code}", timeout=120)
            checks.check(done.returncode == 0, "not paired")

        def updated():
            done = owner.update(maker.release("two"))
            is_confirmed(board, 1, "b", done, report)
            frames_come(board.rig, report, "slot b, updated")

        def reverted():
            done = owner.run("update", "--revert", owner.place, "--wait", PROVEN_S, "--timeout", 5)
            is_confirmed(board, 2, "a", done, report)
            frames_come(board.rig, report, "slot a, reverted")

        cases = {"updated": updated, "reverted": reverted}
        for what, release in failing(maker):
            cases[what.replace(" ", "_")] = lambda what=what, release=release: is_left(board, owner, release(), report, what)
        if report.run("first_start", first_start):
            for name, case in cases.items():
                if not options.case or name in options.case:
                    report.run(name, case)
        told(board)
    return ended(report)


def main():
    parser = arguments(__doc__, "update")
    parser.add_argument("--logs", action="store_true", help="leave what each start wrote, for image_cuts.py")
    parser.add_argument("--case", action="append", help="only these: updated, reverted (after it), ends_at_once, hangs_before_stofd, panics")
    return run(parser.parse_args())


if __name__ == "__main__":
    sys.exit(main())
