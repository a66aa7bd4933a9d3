"""Cases of other wiring than the board's table has: strobe lines, both views of one camera, a PMD sensor on V4L2.

Each takes (bench, report); bench.rig() starts a rig of its own.
"""

import itertools
import time

import cases
import checks
import rig as system_rig
import uvc_camera

CHIP = "9030000.pl061"
STROBE_EDGES = 60
STROBE_SHARE = 0.5
STROBE_ROUNDS = 3
STROBE_READOUT_S = 0.02  # a picture over USB 2; its strobe has ended by then, also here
CUT_EDGES = 15
BACK_S = 5.0  # pictures are believed again after some that follow each other, in time
SIDE_BY_SIDE_EDGES = 30
PMD_EDGES = 30
PMD_EXPOSURE = 160  # 100 us: all four samples, the board's table
PMD_SAMPLES = 4


def strobes(bench, report):
    """Exposures are what the cameras' strobe lines say. Here a strobe goes through this program and QEMU: a busy
    machine makes it late, or both its edges come as one. A frame whose strobe is later than the board's tolerance
    of 12 ms must be dropped, and so are one or two that follow it, until pictures and exposures are counted alike
    again. So half of the edges must give a frame in the best of a few rounds, which says that strobes are used, not
    how good they are on a board; a wrong frame is one too many in every round."""
    # A frame says that both strobes were there.
    lines = ["--set", "depth.require=both", "--left-strobe", f"{CHIP}:{system_rig.LEFT_STROBE}", "--right-strobe",
             f"{CHIP}:{system_rig.RIGHT_STROBE}"]
    with bench.rig("strobes", arguments=lines) as rig:
        for name in ("left", "right"):
            rig.cameras[name].readout_s = STROBE_READOUT_S
        cases.first_frame(rig, report)
        shares = []
        while len(shares) < STROBE_ROUNDS and max(shares, default=0) < STROBE_SHARE:
            verdict = cases.shown(rig, report, rig.receiver.count(), STROBE_EDGES, 1)
            steps = verdict["steps"]
            shares.append(len(set(steps)) / (max(steps) - min(steps) + 1))
        report.figure(f"edges that gave a frame, by strobes, best of {len(shares)}", f"{max(shares):.0%}",
                      f">= {STROBE_SHARE:.0%}", max(shares) >= STROBE_SHARE)
        late = sorted(rig.strobe_late)
        report.figure("a strobe changes to the machine has it, median and most",
                      f"{late[len(late) // 2] * 1e3:.1f} and {late[-1] * 1e3:.1f} ms", "told", True)
        table = sum(frame["end_ns"] - frame["begin_ns"] == cases.STEREO_EXPOSURE_US * 1000
                    for frame in rig.receiver.frames if "end_ns" in frame)
        report.none("frames with an exposure of the board's table, not of a strobe", table)
        for name in ("left", "right"):
            strobe_cut(rig, report, name)
            every_second_strobe(rig, report, name)


def strobe_cut(rig, report, name):
    camera = rig.cameras[name]
    strobe, camera.strobe = camera.strobe, None
    rig.at_step(rig.steps() + 1)
    time.sleep(0.3)  # what exposed before has arrived
    since, delivered = rig.receiver.count(), camera.delivered
    rig.at_step(rig.steps() + CUT_EDGES)
    report.none(f"frames without the {name} camera's strobe", rig.receiver.count() - since)
    checks.check(camera.delivered - delivered >= CUT_EDGES - 2, f"the {name} camera sent no pictures meanwhile")
    camera.strobe = strobe
    comes_back(rig, report)


def comes_back(rig, report):
    since, begin = rig.receiver.count(), time.monotonic()
    rig.receiver.wait(lambda frame: frame["missing"] == 0, since, timeout=20, what="frame since strobes are back")
    report.at_most("strobes are back to next frame", time.monotonic() - begin, BACK_S, "s")
    cases.shown(rig, report, since, CUT_EDGES, 1)


def every_second_strobe(rig, report, name):
    """A picture without a strobe must not take that of the edge before or after it. There need be no frame: as long as
    pictures and exposures are not equally many, none is believed."""
    camera = rig.cameras[name]
    strobe, changes = camera.strobe, itertools.count()
    camera.strobe = lambda level: strobe(level) if next(changes) % 4 < 2 else None
    rig.at_step(rig.steps() + 1)
    verdict = cases.shown(rig, report, rig.receiver.count(), CUT_EDGES, 0)
    camera.strobe = strobe
    comes_back(rig, report)
    most = CUT_EDGES // 2 + 2  # it begins and ends within a period
    report.figure(f"frames with every second strobe of the {name} camera", f"{verdict['frames']} of {CUT_EDGES} edges",
                  f"<= {most}", verdict["frames"] <= most)


def side_by_side(bench, report):
    scene = bench.scene
    width, height = system_rig.STEREO

    def both(left, right):
        rows = range(0, width * height, width)
        return b"".join(left[at:at + width] + right[at:at + width] for at in rows)

    pictures = [both(left, right) for left, right in zip(scene.left, scene.right)]
    camera = system_rig.uvc(0x51, "both", (2 * width, height), pictures, ("GREY",))
    plugs = {"left": system_rig.Plug(camera, system_rig.LEFT_LINE), **system_rig.usb_pmd(scene)}
    with bench.rig("side-by-side", plugs=plugs, arguments=["--right", "none"]) as rig:
        cases.first_frame(rig, report)
        cases.edges_give_frames(rig, report, SIDE_BY_SIDE_EDGES)
        cases.replug(rig, report, "left")


class StackedPmd(uvc_camera.UvcCamera):
    """The four samples one below the other, in any format of 16 bits: pictures are bytes as they are sent."""

    first_exposure = PMD_EXPOSURE

    def pixels(self, name, k):
        return self.pictures[k]


def pmd_v4l2(bench, report):
    scene = bench.scene
    width, height = system_rig.PMD
    for name in ("Y16", "Y12"):
        if name == "Y12" and scene.pmd_bits > 12:
            raise checks.Failure(f"the scene's samples have {scene.pmd_bits} bits, more than {name}")

        def make(path, schedule, name=name):
            return StackedPmd(path, schedule, 0x53, "PMD sensor", (width, PMD_SAMPLES * height), scene.pmd, (name,))

        plugs = {**system_rig.stereo_pair(scene), "pmd": system_rig.Plug(make, system_rig.PMD_LINE)}
        with bench.rig(f"pmd-v4l2-{name}", plugs=plugs, arguments=["--pmd", "usb:1209:0053"]) as rig:
            cases.first_frame(rig, report)
            cases.edges_give_frames(rig, report, PMD_EDGES)
            with_pmd = sum(frame.get("pmd", 0) for frame in rig.receiver.frames)
            report.figure(f"frames with a PMD picture, {name}", f"{with_pmd} of {rig.receiver.count()}", ">= 90%",
                          with_pmd >= 0.9 * rig.receiver.count())
            cases.replug(rig, report, "pmd")


LONG = (strobes, side_by_side, pmd_v4l2)
