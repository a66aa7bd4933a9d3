"""A board's stofd on the kernel's own driver of a Raspberry Pi's GPIO: QEMU's raspi3b, no camera, no network.

The driver of the Pi 4 drives the pin controller of that Pi, and its lines have the same names. What else a Pi 4 has
(PCIe, USB 3, Ethernet), QEMU has not.
"""

import re
import statistics
import subprocess
import threading

import initramfs
import checks
import machine

BOARD, TREE = "raspi3b", "usr/lib/linux-image-*/broadcom/bcm2837-rpi-3-b.dtb"
# board/rpi4/config.h, in the order in which they rise; and the strobes.
TRIGGERS, STROBES = ("GPIO17", "GPIO27", "GPIO22"), ("GPIO23", "GPIO24")
COMMAND = (b"/bin/stofd --uncalibrated --pmd none --watchdog none"
           b" --left-strobe GPIO23 --right-strobe GPIO24")
BOOT_S = 120.0
LEAST_PULSES = 20
APART_US = 1000  # of the lines of one edge, on an emulated processor


def tell(stofd, work):
    """What the guest has told: its lines without "END"."""
    work.mkdir(parents=True, exist_ok=True)
    tree = next(iter(sorted(initramfs.KERNEL.glob(TREE))), None)
    if tree is None:
        raise checks.Failure(f"no {TREE} in {initramfs.KERNEL}: remove it, toolchains/kernel.sh makes it anew")
    initramfs.build(work / "initramfs", [(COMMAND, "command")], [(stofd, "bin/stofd")], modules=(),
                    init=initramfs.GUEST / "init_lines")
    command = [*machine.ENDS_WITH_US, machine.QEMU, "-M", BOARD, "-dtb", tree, "-kernel", initramfs.KERNEL / "image",
               "-initrd", work / "initramfs", "-append", "console=ttyAMA0 quiet loglevel=1 panic=-1", "-display",
               "none", "-nodefaults", "-serial", "stdio", "-no-reboot"]
    lines = []
    process = subprocess.Popen([str(word) for word in command], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True, errors="replace")
    late = threading.Timer(BOOT_S, process.kill)
    late.start()
    try:
        for raw in process.stdout:
            line = raw.strip()
            if line == "END":
                return lines
            lines.append(line)
        raise machine.MachineError(f"{BOARD} did not tell in {BOOT_S} s; last:\n" + "\n".join(lines[-10:]))
    finally:
        late.cancel()
        process.kill()  # a Pi does not leave QEMU at power off
        process.wait()
        process.stdout.close()
        (work / "console.log").write_text("\n".join(lines))


def lines_of(told):
    """{the line's name: (its number, "in" or "out")}: those that stofd holds."""
    held = {}
    for line in told:
        found = re.match(r"LINE gpio-(\d+) +\((\S+) *\|stof *\) +(in|out)", line)
        if found:
            held[found[2]] = (int(found[1]), found[3])
    return held


def changes_of(told):
    """[(seconds, the line's number, level)]"""
    found = (re.search(r" (\d+\.\d+): gpio_value: (\d+) set (\d)", line) for line in told if line.startswith("CHANGE"))
    return [(float(change[1]), int(change[2]), int(change[3])) for change in found if change]


def rpi4_lines(bench, report):
    stofd = bench.options.rpi4
    checks.check(stofd.exists(), f"{stofd} is missing: build preset rpi4")
    told = tell(stofd, bench.work / "rpi4-lines")
    held = lines_of(told)
    for names, direction in ((TRIGGERS, "out"), (STROBES, "in")):
        for name in names:
            got = held.get(name, (0, "not held"))[1]
            report.figure(f"line {name}", got, direction, got == direction)
    waits = [line for line in told if line.startswith("LOG") and "waiting for the stereo cameras" in line]
    report.figure("it says that it waits for its cameras", len(waits), "1", len(waits) == 1)

    changes = changes_of(told)
    numbers = [held[name][0] for name in TRIGGERS]
    rises = [(at, line) for at, line, level in changes if level and line in numbers]
    pulses = [rises[k:k + len(numbers)] for k in range(0, len(rises) - len(numbers) + 1, len(numbers))]
    report.figure("pulses on all three lines", len(pulses), f">= {LEAST_PULSES}", len(pulses) >= LEAST_PULSES)
    wrong = [pulse for pulse in pulses if [line for _, line in pulse] != numbers]
    report.none("pulses in another order, or not on all lines", len(wrong))
    checks.check(pulses, "no pulses were seen")
    apart = statistics.median(pulse[-1][0] - pulse[0][0] for pulse in pulses) * 1e6
    report.at_most("lines rise apart, median", apart, APART_US, "us")
    periods = [second[0][0] - first[0][0] for first, second in zip(pulses, pulses[1:])]
    report.figure("period, median", f"{statistics.median(periods) * 1e3:.1f} ms", "told", True)
