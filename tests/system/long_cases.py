"""Cases with rigs of their own: boot, endurance, outages, pixel formats, lateness, the watchdog, the libcamera variant.

Each takes (bench, report); bench.rig() starts a rig of its own.
"""

import re
import statistics
import time

import cases
import checks
import rig as system_rig

BOOT_BAR_S = 3.0  # from the kernel's start to the first frame
BOOTS = 8
EDGES = 1000
REPLUGS = 20
LIBCAMERA_BACK_BAR_S = 3.0  # it looks at all devices again
LATENESS_BAR_US = 200
LATENESS_EDGES = 60
LATENESS_PERIOD_MS = 200
GIGAHERTZ = "shift=0"
VIRTUAL_TIME = "shift=2,sleep=off"  # no device that the host drives, see machine.Machine
WATCHDOG_S = 15  # the board's table
TRACE = "/sys/kernel/tracing"


def boot(bench, report):
    """In virtual time, a nanosecond an instruction: a gigahertz, whatever this machine does beside. Cameras are as
    slow as they are, so the fastest of a few boots counts."""
    seconds = []
    while len(seconds) < BOOTS and min(seconds, default=BOOT_BAR_S + 1) > BOOT_BAR_S:
        with bench.rig("boot", processors=1, icount=GIGAHERTZ) as rig:
            seconds.append(cases.first_frame(rig, report))
    report.at_most(f"boot to first frame, guest time, best of {len(seconds)}", min(seconds), BOOT_BAR_S, "s")


def thousand_edges(bench, report):
    with bench.rig("edges") as rig:
        cases.first_frame(rig, report)
        cases.edges_give_frames(rig, report, EDGES, rounds=1)
        cases.ends_as_asked(rig, report)


def many_replugs(bench, report):
    with bench.rig("replugs") as rig:
        cases.first_frame(rig, report)
        for name in rig.cameras:
            seconds = [cases.replug(rig, report, name) for _ in range(REPLUGS)]
            report.at_most(f"{name} camera, slowest of {REPLUGS} returns", max(seconds), cases.BACK_BAR_S, "s")
            report.figure(f"{name} camera, median return", f"{statistics.median(seconds):.2f} s", "told", True)
        cases.edges_give_frames(rig, report)


def long_outages(bench, report):
    with bench.rig("outages") as rig:
        cases.first_frame(rig, report)
        for out in (cases.RIGHT_UNPLUGGED, cases.LEFT_FROZEN, cases.RIGHT_FROZEN, cases.PMD_FROZEN, cases.PMD_DARK):
            cases.lose(rig, report, out, cases.OUT_S)


def formats(bench, report):
    for name in ("YUYV", "Y10", "Y12", "Y16"):
        plugs = {**system_rig.stereo_pair(bench.scene, (name,)), **system_rig.usb_pmd(bench.scene)}
        with bench.rig(f"format-{name}", plugs=plugs) as rig:
            rig.receiver.wait(lambda frame: "latency_ns" in frame, timeout=60, what=f"frame from {name} pictures")
            chosen = rig.cameras["left"].format()
            report.figure("pixel format", chosen, name, chosen == name)
            cases.shown(rig, report, 0, 15, 13)


def libcamera(bench, report):
    if bench.libcamera is None:
        raise checks.Failure("no stofd-libcamera was named")
    with bench.rig("libcamera", variant="libcamera") as rig:
        rig.receiver.wait(lambda frame: "latency_ns" in frame, timeout=90, what="frame by libcamera")
        cases.edges_give_frames(rig, report)
        for name in rig.cameras:
            cases.replug(rig, report, name, LIBCAMERA_BACK_BAR_S)


def watchdog(bench, report):
    with bench.rig("watchdog", watchdog="reset", reboot=True) as rig:
        rig.receiver.wait(lambda frame: "latency_ns" in frame, timeout=60, what="first frame")
        since = len(rig.machine.console.events)
        rig.machine.ask("stop")
        begin = time.monotonic()
        rig.machine.console.event("init", since, timeout=WATCHDOG_S * 3)
        report.at_most("stofd stands still to the machine's restart", time.monotonic() - begin, WATCHDOG_S * 2, "s")
        number = rig.receiver.count()
        session = rig.receiver.frames[-1]["session"]
        rig.receiver.wait(lambda frame: frame["session"] != session and frame["missing"] == 0, number, timeout=60,
                          what="frame after the restart")


def edge_times(lines):
    """Seconds at which line 0's output rose, from the kernel's trace of GPIO values."""
    times = []
    for line in lines:
        found = re.search(r" (\d+\.\d+): gpio_value: (\d+) set (\d)", line)
        if found:
            times.append((float(found[1]), int(found[2]), int(found[3])))
    first = min((line for _, line, _ in times), default=None)
    return [at for at, line, level in times if line == first and level == 1]


def lateness(bench, report):
    """Processors in virtual time, so that what this machine does beside does not count."""
    arguments = ["--pmd", "none", "--uncalibrated", "--period-ms", str(LATENESS_PERIOD_MS), "--watchdog", "none"]
    seen = {}
    for policy, more in (("FIFO", []), ("OTHER", ["--priority", "0"])):
        with bench.rig(f"lateness-{policy}", plugs={}, common=False, arguments=arguments + more, serial=False,
                       icount=VIRTUAL_TIME, processors=1) as rig:
            rig.machine.console.event("start", timeout=120)
            ask = rig.machine.ask
            ask(f"sh mount -t tracefs trace {TRACE}; echo mono >{TRACE}/trace_clock;"
                f" echo 1 >{TRACE}/events/gpio/gpio_value/enable", timeout=120)
            ask("load", timeout=120)
            ask(f"sh sleep {LATENESS_EDGES * LATENESS_PERIOD_MS / 1000}; echo 0 >{TRACE}/tracing_on", timeout=300)
            times = edge_times(ask(f"sh grep gpio_value {TRACE}/trace", timeout=300))
        checks.check(len(times) >= LATENESS_EDGES / 2, f"{len(times)} edges were traced")
        period = LATENESS_PERIOD_MS / 1000
        phases = [(at - times[0] + period / 2) % period for at in times]
        seen[policy] = (max(phases) - min(phases)) * 1e6
    report.at_most("edges late, SCHED_FIFO, virtual time, under load", seen["FIFO"], LATENESS_BAR_US, "us")
    report.figure("edges late, SCHED_OTHER, likewise", f"{seen['OTHER']:.0f} us", "told", True)


BRIEF = (boot,)
LONG = (thousand_edges, many_replugs, long_outages, formats, lateness, watchdog, libcamera)
