"""What the appliance promises, as cases that share one running rig. Each takes (rig, report)."""

import collections
import functools
import re
import time

import checks
import machine
import rig as system_rig
import serial_line
import triggered_camera

BACK_BAR_S = 2.0  # from a camera's return, or the program's end, to the next frame
UNPLUGGED_S = 0.5
OUT_S = 10.0
BRIEFLY_OUT_S = 1.0
MOST_PERIODS = 3  # between two frames, whatever is unplugged
TOLD_BAR_S = 2 * system_rig.PERIOD_S  # from a sensor's loss to the first word of it: the next edge's, and a period
CONDITION_BAR_S = 4 * system_rig.PERIOD_S  # to its condition: three edges, and a period
PRIORITY = 45
FIFO = 1
WORKERS = "stof-depth"  # what their names begin with
STEREO_EXPOSURE_US = 4_000
FAULTS_APART = 5  # edges
SUBSCRIBED_S = 2.0
SUBSCRIBED_EDGES = 15


def shown(rig, report, since, edges, least):
    """Lets `edges` edges go by; all frames since number `since` must be of their edges, `least` of them at least."""
    begin = rig.steps()
    rig.at_step(begin + edges, timeout=30 + edges * 0.4)  # twice the period
    time.sleep(0.3)  # what the last but one gave has arrived
    verdict = rig.judge(rig.receiver.frames[since:])
    report.none("frames that are not of their edge", verdict["mispaired"])
    report.none("frames that differ from the host's", verdict["different"])
    checks.check(verdict["frames"] >= least, f"{verdict['frames']} frames of {edges} edges, at least {least} are "
                 f"wanted; the program said {rig.log()[-5:]}")
    return verdict


def first_frame(rig, report):
    """Seconds from the kernel's start to the first packet of the first frame, in the guest's time."""
    frame = rig.receiver.wait(lambda frame: "latency_ns" in frame, timeout=60, what="first frame")
    seconds = (frame["middle_ns"] + frame["latency_ns"]) * 1e-9
    start = rig.machine.console.event("start")
    report.figure("boot to the program's start and to the first frame, guest time",
                  f"{start.uptime:.2f} and {seconds:.2f} s", "told", True)
    return seconds


def edges_give_frames(rig, report, edges=60, rounds=2):
    """Every edge gives a frame, and none is wrong in any round. A machine that does not get its turn on this one loses
    frames, and says so: then one more round."""
    for left in reversed(range(rounds)):
        verdict = shown(rig, report, rig.receiver.count(), edges, 1)
        steps = verdict["steps"]
        missing = len(set(range(steps[0], steps[-1] + 1)) - set(steps))
        if missing == 0 and verdict["frames"] >= edges - 2 or left == 0:
            break
        print(f"  {missing} edges without a frame, once more; the program said {rig.log()[-3:]}")
    checks.check(verdict["frames"] >= edges - 2, f"{verdict['frames']} frames of {edges} edges; the program said "
                 f"{rig.log()[-5:]}")
    report.figure("edges", edges, f">= {edges}", True)
    report.none("frames that did not arrive whole", verdict["incomplete"])
    report.none("edges in between without a frame", missing)
    report.none("edges with two frames", len(steps) - len(set(steps)))


def subscribed(rig, report):
    """A receiver asks for frames, as libstof does, and is let go."""
    begin = time.monotonic()
    receiver = system_rig.Receiver(rig.scene.receive, "--sensor", f"127.0.0.1:{rig.machine.port}")
    try:
        receiver.wait(lambda frame: frame["missing"] == 0 and frame["depth"], timeout=20, what="frame by subscription")
        report.at_most("subscription to first whole frame", time.monotonic() - begin, SUBSCRIBED_S, "s")
        number, since = rig.steps(), receiver.count()
        rig.at_step(number + SUBSCRIBED_EDGES)
        time.sleep(0.3)
        verdict = rig.judge(receiver.frames[since:])
    finally:
        receiver.close()
    report.none("subscribed frames that are not of their edge", verdict["mispaired"])
    report.none("subscribed frames that differ from the host's", verdict["different"])
    report.none("subscribed frames that did not arrive whole", verdict["incomplete"])
    report.figure("subscribed frames", f"{verdict['frames']} of {SUBSCRIBED_EDGES} edges", f">= {SUBSCRIBED_EDGES - 2}",
                  verdict["frames"] >= SUBSCRIBED_EDGES - 2)


def controls(rig, report):
    for name in ("left", "right"):
        settings = rig.cameras[name].exposures[-1].settings
        checks.check(not settings["auto"], f"the {name} camera chooses its exposure by itself")
        report.figure(f"exposure of the {name} camera", f"{settings['exposure_us']} us", f"{STEREO_EXPOSURE_US} us",
                      settings["exposure_us"] == STEREO_EXPOSURE_US)
    lines = [rig.edges[line] for line in sorted(rig.edges)]
    apart = [max(times) - min(times) for times in zip(*(line[-20:] for line in lines))]
    report.figure("lines rise apart, as the host sees it", f"{max(apart) * 1e6:.0f} us", "told", True)


def read_process(rig):
    """{"uptime": .., "realtime": .., ..., "tasks": [{...}]} of the program's process."""
    process = {"tasks": []}
    for line in rig.machine.ask("proc"):
        words = line.split()
        if words[0] == "task":
            head, name = line.split(" comm ", 1)
            fields = head.split()
            task = {key: int(value) for key, value in zip(fields[2::2], fields[3::2])}
            process["tasks"].append({"id": int(fields[1]), "name": name, **task})
        elif len(words) > 1:
            process[words[0]] = words[1]
    return process


def real_time(rig, report):
    before = read_process(rig)
    rig.at_step(rig.steps() + 20)
    after = read_process(rig)
    report.figure("kernel is real-time", after.get("realtime"), "1", after.get("realtime") == "1")
    report.figure("memory locked", f"{after.get('VmLck')} kB", "> 0", int(after.get("VmLck", 0)) > 0)
    loop = after["tasks"][0]
    report.figure("loop's policy and priority", f"{loop['policy']}, {loop['rt']}",
                  f"{FIFO}, which is SCHED_FIFO, {PRIORITY}", (loop["policy"], loop["rt"]) == (FIFO, PRIORITY))
    old = {task["id"]: task for task in before["tasks"]}
    checks.check(set(old) == {task["id"] for task in after["tasks"]}, "a thread came or went between two readings")
    # The loop and those that compute with it; the control thread is as others are, and may fault.
    urgent = [task for task in after["tasks"] if task is loop or task["name"].startswith(WORKERS)]
    checks.check(len(urgent) > 1, "no thread helps the loop to compute")
    for task in urgent:
        report.figure(f"policy of thread {task['name']}", task["policy"], f"{FIFO}, SCHED_FIFO", task["policy"] == FIFO)
        for kind in ("minflt", "majflt"):
            report.none(f"{kind} of thread {task['name']} in 20 edges", task[kind] - old[task["id"]][kind])


def recovers(rig, report, break_it, lost=2):
    """A fault of one edge costs at most `lost` frames, and none that follows is wrong."""
    rig.at_step(rig.steps())
    since = rig.receiver.count()
    break_it()
    shown(rig, report, since, FAULTS_APART + lost, FAULTS_APART - 1)


def lost_edge(rig, report):
    for name in ("left", "right", "pmd"):
        recovers(rig, report, lambda name=name: rig.cameras[name].fail_next(triggered_camera.DROP))


def late_frame(rig, report):
    # Until shortly after the next edge, when it looks like that one's picture; and beyond the one after it.
    for name in ("left", "right", "pmd"):
        for seconds in (0.21, 0.25, 0.45):
            recovers(rig, report, lambda name=name, seconds=seconds:
                     rig.cameras[name].fail_next(triggered_camera.DELAY, seconds), lost=5)


def broken_frame(rig, report):
    for kind in (triggered_camera.SHORT, triggered_camera.CORRUPT):
        for name in ("right", "pmd"):
            recovers(rig, report, lambda kind=kind, name=name: rig.cameras[name].fail_next(kind), lost=3)


def whole(frame):
    """It arrived as it was sent, and stands on both sensors."""
    return frame["missing"] == 0 and frame.get("sensors") == system_rig.BOTH


def replug(rig, report, name, bar=BACK_BAR_S):
    """Seconds from the camera's return to the next frame of both sensors."""
    camera = rig.cameras[name]
    since = rig.receiver.count()
    camera.unplug()
    time.sleep(UNPLUGGED_S)
    steps = rig.steps()
    begin = time.monotonic()
    camera.plug()
    number = rig.receiver.count()
    rig.receiver.wait(whole, number, timeout=20, what=f"frame after the {name} camera's return")
    seconds = time.monotonic() - begin
    report.at_most(f"{name} camera plugged in to next frame", seconds, bar, "s")
    checks.check(rig.steps() > steps, "the trigger stood still")
    shown(rig, report, since, 4, 3)
    return seconds


def replugs(rig, report):
    for name in rig.cameras:
        replug(rig, report, name)


def pmd_stall(rig, report):
    since = rig.receiver.count()
    rig.cameras["pmd"].stall(True)
    time.sleep(1.0)
    rig.cameras["pmd"].stall(False)
    begin, number = time.monotonic(), rig.receiver.count()
    rig.receiver.wait(whole, number, timeout=20, what="frame after the PMD camera's stall")
    report.at_most("PMD camera answers again to next frame", time.monotonic() - begin, BACK_BAR_S, "s")
    shown(rig, report, since, 4, 4)


# begin: takes the camera, tells when it fell out; end: takes the camera.
Outage = collections.namedtuple("Outage", "name camera begin end goes_on condition")
# What the frames of one sensor alone stand on.
PAIR_ALONE, PMD_ALONE = 1, 2


def unplug(camera):
    """When it was pulled out."""
    began = time.monotonic()
    camera.unplug()
    return began


def ail(camera, ailment):
    """When the first picture was exposed that shows it."""
    camera.fall_ill(ailment)
    end = time.monotonic() + 5 * system_rig.PERIOD_S
    while camera.ails_since is None and time.monotonic() < end:
        time.sleep(0.005)
    checks.check(camera.ails_since is not None, "the camera was not triggered")
    return camera.ails_since


FROZEN = functools.partial(ail, ailment=triggered_camera.FROZEN)
DARK = functools.partial(ail, ailment=triggered_camera.DARK)
PLUG, CURE = triggered_camera.TriggeredCamera.plug, triggered_camera.TriggeredCamera.cure
PMD_UNPLUGGED = Outage("PMD camera unplugged", "pmd", unplug, PLUG, PAIR_ALONE, "pmd_lost")
LEFT_UNPLUGGED = Outage("left camera unplugged", "left", unplug, PLUG, PMD_ALONE, "stereo_lost")
RIGHT_UNPLUGGED = Outage("right camera unplugged", "right", unplug, PLUG, PMD_ALONE, "stereo_lost")
LEFT_FROZEN = Outage("left camera frozen", "left", FROZEN, CURE, PMD_ALONE, "stereo_frozen")
RIGHT_FROZEN = Outage("right camera frozen", "right", FROZEN, CURE, PMD_ALONE, "stereo_frozen")
PMD_FROZEN = Outage("PMD camera frozen", "pmd", FROZEN, CURE, PAIR_ALONE, "pmd_frozen")
PMD_DARK = Outage("PMD camera's lamp dark", "pmd", DARK, CURE, PAIR_ALONE, "pmd_dark")


def go_without(rig, report, out, seconds):
    """Loses a sensor for a while. Seconds until both are there again, the longest time between two frames, and how soon
    it was told: by a frame that stands on what is left, or by the condition; and by the condition."""
    camera = rig.cameras[out.camera]
    rig.receiver.wait(whole, rig.receiver.count(), timeout=60, what="frame of both")
    events = len(rig.receiver.events)
    began = out.begin(camera)
    since = rig.receiver.count()
    time.sleep(seconds)
    during = rig.receiver.frames[since:]
    out.end(camera)
    back, number = time.monotonic(), rig.receiver.count()
    rig.receiver.wait(whole, number, timeout=20, what=f"frame of both after: {out.name}")
    back = time.monotonic() - back
    seen = [began, *(frame["seen"] for frame in rig.receiver.frames[since:]), time.monotonic()]
    alone = [frame["seen"] - began for frame in during if frame.get("sensors") == out.goes_on]
    told = [event["at_ns"] * 1e-9 - began for event in rig.receiver.events[events:]
            if event["event"] == out.condition and event["active"]]
    checks.check(bool(told), f"nobody said {out.condition}")
    checks.check(len(alone) >= 0.9 * seconds / system_rig.PERIOD_S - 1,
                 f"{len(alone)} frames of what was left in {seconds} s")
    shown(rig, report, since, 4, 3)
    return back, max(after - before for before, after in zip(seen, seen[1:])), min(alone[0], told[0]), told[0]


def lose(rig, report, out, seconds):
    """A sensor is out: frames go on with the other one, it is told, and nothing of it is shown. A machine that does not
    get its turn on this one is late, and says so: then one more round."""
    bars = (BACK_BAR_S, MOST_PERIODS * system_rig.PERIOD_S, TOLD_BAR_S, CONDITION_BAR_S)
    for _ in range(2):
        log = len(rig.log())
        found = go_without(rig, report, out, seconds)
        if all(value <= bar for value, bar in zip(found, bars)) or not any("late" in line for line in rig.log()[log:]):
            break
        print(f"  {out.name}: late, once more; the program said {rig.log()[-3:]}")
    for what, value, bar in zip(("its end to the next frame of both", "longest time between two frames",
                                 "until a frame or a condition tells it", f"until {out.condition}"), found, bars):
        report.at_most(f"{out.name}: {what}", value, bar, "s")


def outages(rig, report):
    for out in (PMD_UNPLUGGED, LEFT_UNPLUGGED):
        lose(rig, report, out, OUT_S)
    for out in (RIGHT_FROZEN, PMD_FROZEN, PMD_DARK):
        lose(rig, report, out, BRIEFLY_OUT_S)


def killed(rig, report):
    session = rig.receiver.frames[-1]["session"]
    since = rig.receiver.count()
    begin = time.monotonic()
    rig.machine.ask("kill9")
    rig.receiver.wait(lambda frame: frame["session"] != session and frame["missing"] == 0, since, timeout=20,
                      what="frame of a new session")
    report.at_most("kill -9 to next frame", time.monotonic() - begin, BACK_BAR_S, "s")
    shown(rig, report, since, 5, 4)


def serial(rig, report):
    with serial_line.SerialLine(rig.machine) as line:
        count = line.frames(1.5)
    report.figure("frames on the serial line in 1.5 s", count, ">= 3", count >= 3)
    # Nobody holds the other end: the line's bytes go nowhere, frames by UDP must not wait for it.
    since = rig.receiver.count()
    shown(rig, report, since, 10, 9)
    with serial_line.SerialLine(rig.machine) as line:
        count = line.frames(1.5)
    report.figure("frames on the serial line after it was cut", count, ">= 3", count >= 3)
    checks.check(line.damaged <= 1, f"{line.damaged} damaged packets on the serial line")  # one was cut


def ends_as_asked(rig, report):
    since = len(rig.machine.console.events)
    rig.machine.ask("hold")
    rig.machine.ask("term")
    try:
        end = rig.machine.console.event("end", since, timeout=15)
    except machine.MachineError:
        raise checks.Failure("it does not end at SIGTERM") from None
    report.figure("exit code after SIGTERM", end.more, "0", end.more == "0")
    summary = rig.machine.console.line("frames published of", timeout=5).text
    print("  " + summary)
    heap = rig.machine.console.line("heap calls in the loop", timeout=5).text
    own = re.search(r"(\d+) of our own", heap)
    report.figure("heap calls of our own in the loop", own[1] if own else heap, "0", bool(own) and own[1] == "0")
    print("  " + heap)


SHORT = (first_frame, edges_give_frames, subscribed, controls, real_time, lost_edge, late_frame, broken_frame, replugs,
         pmd_stall, outages, killed, serial, ends_as_asked)
