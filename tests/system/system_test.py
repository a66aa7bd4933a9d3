#!/usr/bin/env python3
"""The system test: stofd for board `virt` on Debian's PREEMPT_RT kernel in QEMU, its cameras served by this program.

Edges on the board's GPIO lines expose the cameras, as on a rig; every frame that arrives must be the one that the same
sources compute on this machine from what those edges exposed, bit by bit. tests/system/README.md tells more.
"""

import argparse
import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import time

import cases
import initramfs
import checks
import libcamera_image
import long_cases
import machine
import pi_gpio
import rig
import wiring_cases

ROOT = initramfs.ROOT
LONG = (*long_cases.LONG, *wiring_cases.LONG, pi_gpio.rpi4_lines)


class Bench:
    """What was built, and where to work."""

    def __init__(self, options):
        self.options = options
        self.work = pathlib.Path(options.work)
        self.work.mkdir(parents=True, exist_ok=True)
        self.scene = rig.Scene(options.programs, self.work / "scenes")
        self.libcamera = options.libcamera if pathlib.Path(options.libcamera).exists() else None

    def rig(self, name, variant=None, arguments=(), common=True, **more):
        arguments = [*(["--serial", "/dev/ttyS0", "--set", "serial.mode=stof"] if more.get("serial", True) else []),
                     *arguments]
        stofd = self.options.stofd
        if variant == "libcamera":
            stofd = self.libcamera
            arguments += ["--cameras", "libcamera"]
            more.update(libraries=self.options.sysroot, image_extra=libcamera_image.add, memory="768")
        return rig.Rig(self.scene, stofd, self.work / name, arguments=arguments, common=common, **more)


def run(options):
    begin = time.monotonic()
    bench = Bench(options)
    print(f"scene and what the host computes of it: {time.monotonic() - begin:.1f} s", flush=True)
    report = checks.Report()
    wanted = [name for name in options.case if name]
    short = [case for case in cases.SHORT if not wanted or case.__name__ in wanted]
    if short and (options.short or wanted):
        with bench.rig("short") as shared:
            for case in short:
                if not report.run(case.__name__, case, shared, report) and not shared.receiver.count():
                    print("\n".join(shared.log()[-20:]))
                    break  # nothing works without
    for case in (*long_cases.BRIEF, *LONG):
        by_default = options.long or (options.short and case in long_cases.BRIEF)
        if case.__name__ in wanted if wanted else by_default:
            report.run(case.__name__, case, bench, report)
    print(f"{report.passed} passed, {report.failed} failed")
    return 1 if report.failed or not report.passed else 0


def parse():
    names = [case.__name__ for case in (*cases.SHORT, *long_cases.BRIEF, *LONG)]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], epilog="cases: " + ", ".join(names))
    parser.add_argument("--short", action="store_true", help="up to four minutes (default)")
    parser.add_argument("--long", action="store_true", help="all that, and a quarter of an hour")
    parser.add_argument("--case", action="append", default=[], choices=names, help="these alone", metavar="NAME")
    parser.add_argument("--stofd", default=ROOT / "build/virt/bin/stofd")
    parser.add_argument("--libcamera", default=ROOT / "build/virt/bin/stofd-libcamera", help="its libcamera variant")
    parser.add_argument("--rpi4", type=pathlib.Path, default=ROOT / "build/rpi4/bin/stofd", help="stofd of board rpi4")
    parser.add_argument("--programs", default=ROOT / "build/emu/bin", help="this machine's stofd and test programs")
    parser.add_argument("--sysroot", default=ROOT / "build/sysroot-arm64", help="libraries of the libcamera variant")
    parser.add_argument("--work", default=ROOT / "build/system", help="where images, scenes and logs go")
    options = parser.parse_args()
    options.short = options.short or options.long or not options.case
    return options


def main():
    options = parse()
    # The cameras' edges must not wait for whatever else this machine does, where we may say so.
    with contextlib.suppress(PermissionError):
        os.nice(-10)
    # A killed test ends its machines as one that has run.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    subprocess.run([ROOT / "toolchains" / "kernel.sh"], check=True)
    for path in (options.stofd, pathlib.Path(options.programs) / "stof_system_receive"):
        if not pathlib.Path(path).exists():
            sys.exit(f"system_test: {path} is missing: build presets virt and emu")
    try:
        return run(options)
    except machine.MachineError as error:
        print(f"system_test: {error}", file=sys.stderr)
        print("0 passed, 1 failed")
        return 1


if __name__ == "__main__":
    sys.exit(main())
