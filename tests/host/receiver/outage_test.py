#!/usr/bin/env python3
"""outage_test.py --period-ms N -- STOFD...: the appliance loses one of its sensors for ten seconds.

Whatever ends the sensor's data, frames go on with the other one and say so, all of them true, the robot is told within
five periods, and both are back within 2 s. All thirteen rigs run at the same time, so that a period has to be long for slow
programs.
"""

import array
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import packets
import receiver

COMMAND = []
FIRST, EDGES, AFTER = 40, 167, 40  # edges before, during and after the outage
STEREO, PMD, BOTH = 1, 2, 3
DEPTH, WIDTH, SOURCE, DISPARITY, LEFT, RIGHT = 1, 2, 3, 4, 6, 7
OF_THE_PAIR = {DISPARITY, LEFT, RIGHT}
NO_DEPTH, FROM_STEREO, FROM_PMD, CONFLICT = 0, 1, 2, 5
DEGRADED = 1
SLOW, STOP = 2, 3
PERIOD_S = float(sys.argv[sys.argv.index("--period-ms") + 1]) / 1000
TOLD_S, BACK_S = 5 * PERIOD_S, 2.0
# Fault, what goes on, the condition that tells it.
OUTAGES = [
    ("pmd:vanish", STEREO, "pmd lost"),
    ("pmd:drop", STEREO, "pmd silent"),
    ("pmd:freeze", STEREO, "pmd frozen"),
    ("pmd:dark", STEREO, "pmd dark"),
    ("stereo:vanish", PMD, "stereo lost"),
    ("stereo:drop", PMD, "stereo silent"),
    ("stereo:repeat", PMD, "stereo frozen"),
    ("stereo:freeze", PMD, "stereo frozen"),
]
# Frozen until it is opened again.
HANGS = [("pmd:hang", STEREO, "pmd frozen"), ("stereo:hang", PMD, "stereo frozen")]


class Frame:
    """What the test looks at."""

    def __init__(self, frame):
        info = frame.arrived[0][packets.PARITY_FIELDS.size :] if 0 in frame.arrived else None
        self.whole = frame.complete()
        self.middle_s = frame.header.exposure * 1e-9
        self.freshness = frame.header.freshness
        self.health = frame.header.health
        self.sensors = info[203] if info else None
        self.edges = struct.unpack_from("<Q", info, 64)[0] if info else None
        self.skipped = struct.unpack_from("<Q", info, 96)[0] if info else None
        self.images = {stream: image[2] for stream, image in frame.images.items()}


class Run(threading.Thread):
    """One sensor with one fault, and a receiver of all it sends."""

    def __init__(self, folder, fault, *settings, flags=()):
        super().__init__()
        self.datagrams, self.frames, self.events = [], [], []
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.settimeout(0.5)
        self.truth_file = pathlib.Path(folder, f"{self.socket.getsockname()[1]}.pfm")
        arguments = ["--size", "64x48", "--period-ms", str(round(PERIOD_S * 1000)), "--port", "0",
                     "--to", f"127.0.0.1:{self.socket.getsockname()[1]}", "--truth", str(self.truth_file),
                     *(("--fault", f"{fault}:{FIRST}+{EDGES}") if fault else ()), *flags]
        for setting in ("discovery.mdns=false", "discovery.beacon=false", "streams.depth=rvl", "streams.width=rvl",
                        "streams.disparity=rvl", "streams.grey_left=rvl", "streams.grey_right=rvl", *settings):
            arguments += ["--set", setting]
        self.sensor = subprocess.Popen([*COMMAND, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                       stderr=subprocess.STDOUT, text=True)
        self.log = ""

    def run(self):
        """Only takes: what reads the packets is too slow for eleven sensors at a time."""
        deadline = time.monotonic() + 120
        edges = 0
        while edges < FIRST + EDGES + AFTER and time.monotonic() < deadline and self.sensor.poll() is None:
            try:
                datagram = self.socket.recv(2048)
            except socket.timeout:
                continue
            self.datagrams.append(datagram)
            if datagram[5] == packets.HEALTH:
                edges = struct.unpack_from("<Q", datagram, packets.HEADER.size + 32)[0]
        self.sensor.terminate()
        self.log = self.sensor.communicate(timeout=60)[0]
        self.socket.close()

    def read(self):
        frames = receiver.Receiver()
        for datagram in self.datagrams:
            header, payload = packets.parse(datagram)
            if header.type == packets.EVENT:
                sequence, condition, _, reaction, active, _, value, at_ns, _ = packets.EVENT_PAYLOAD.unpack_from(payload)
                event = (sequence, receiver.CONDITIONS[condition], reaction, active, value, at_ns * 1e-9)
                if event not in self.events:
                    self.events.append(event)
            self.frames += [Frame(frame) for frame in frames.push(datagram)]

    def truth(self):
        """Z in metres, row by row from the top."""
        kind, size, scale, pixels = self.truth_file.read_bytes().split(b"\n", 3)
        assert kind == b"Pf" and float(scale) < 0
        width = int(size.split()[0])
        values = array.array("f", pixels)
        rows = [values[at : at + width] for at in range(0, len(values), width)]
        return [value for row in reversed(rows) for value in row]


class Outages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory(prefix="stof_") as folder:
            both = ("--pmd", "32x24")
            cls.runs = {fault: Run(folder, fault, flags=both) for fault, _, _ in OUTAGES}
            cls.strict = {fault: Run(folder, fault, "depth.require=both", flags=both)
                          for fault in ("pmd:vanish", "stereo:freeze")}
            cls.hangs = {fault: Run(folder, fault, flags=both) for fault, _, _ in HANGS}
            cls.pair = Run(folder, "", flags=("--pmd", "none"))
            everything = [*cls.runs.values(), *cls.strict.values(), *cls.hangs.values(), cls.pair]
            for run in everything:
                run.start()
            for run in everything:
                run.join()
            cls.truth = next(iter(cls.runs.values())).truth()
        for run in everything:
            run.read()

    def each(self, judge):
        """judge(run, its whole frames, what goes on, the condition) for every outage."""
        for fault, left, condition in OUTAGES:
            with self.subTest(fault):
                run = self.runs[fault]
                frames = [frame for frame in run.frames if frame.whole]
                self.assertGreater(len(frames), FIRST, run.log)
                judge(run, frames, left, condition)

    def test_frames_go_on_and_say_what_they_stand_on(self):
        def judge(run, frames, left, _):
            sensors = [frame.sensors for frame in frames]
            begin, end = sensors.index(left), len(sensors) - sensors[::-1].index(left)
            self.assertEqual(set(sensors[:begin]) | set(sensors[end:]), {BOTH}, run.log)
            self.assertEqual(set(sensors[begin:end]), {left})
            # A machine that does not get its turn skips periods; that is told, and is not the outage's.
            skipped = frames[-1].skipped
            self.assertGreaterEqual(len(run.frames), FIRST + EDGES + AFTER - skipped - 5, run.log)
            gaps = [after.middle_s - before.middle_s for before, after in zip(frames, frames[1:])]
            self.assertLessEqual(max(gaps), (3.5 + skipped) * PERIOD_S)
            self.assertLessEqual(frames[end].middle_s - frames[begin].middle_s, (EDGES + skipped) * PERIOD_S + BACK_S)
            self.assertEqual({frame.health for frame in frames[begin:end]}, {DEGRADED})
        self.each(judge)

    def test_every_frame_is_new(self):
        def judge(_, frames, *__):
            for before, after in zip(frames, frames[1:]):
                self.assertGreater(after.freshness, before.freshness)
                self.assertGreater(after.middle_s, before.middle_s)
        self.each(judge)

    def test_no_frame_has_anything_of_the_sensor_that_is_missing(self):
        def judge(_, frames, left, __):
            allowed = {NO_DEPTH, FROM_STEREO} if left == STEREO else {NO_DEPTH, FROM_PMD, CONFLICT}
            for frame in frames:
                if frame.sensors == left:
                    self.assertLessEqual({value & 15 for value in frame.images[SOURCE]}, allowed)
                pictures = set() if frame.sensors == PMD else OF_THE_PAIR
                self.assertEqual(OF_THE_PAIR & set(frame.images), pictures)
        self.each(judge)

    def judged(self, frames, sensors):
        """Depths a frame, and the shares that their intervals hold, and that are wrong by more than a metre."""
        held = far = count = 0
        frames = [frame for frame in frames if frame.sensors == sensors]
        for frame in frames:
            depth = struct.unpack(f"<{len(self.truth)}H", frame.images[DEPTH])
            width = struct.unpack(f"<{len(self.truth)}H", frame.images[WIDTH])
            for z, w, truth in zip(depth, width, self.truth):
                if z and truth != float("inf"):
                    count += 1
                    held += abs(z / 4000 - truth) <= w / 8000 + 0.001
                    far += abs(z / 4000 - truth) > 1
        return count / len(frames), held / count, far / count

    def test_none_is_wrong(self):
        """The pair alone is as good as that of a rig which has nothing else, the PMD camera alone is right."""
        expected = self.judged([frame for frame in self.pair.frames if frame.whole], STEREO)

        def judge(_, frames, left, __):
            depths, held, far = self.judged(frames, left)
            print(f"{'pair' if left == STEREO else 'PMD'} alone: {depths:.0f} depths a frame, {held:.3f} in their"
                  f" intervals, {far:.4f} wrong by more than 1 m")
            if left == STEREO:
                for value, wanted in zip((depths, held, far), expected):
                    self.assertAlmostEqual(value / wanted, 1, delta=0.02)
            else:
                self.assertGreater(depths, 1000)
                self.assertGreater(held, 0.95)
                self.assertLess(far, 0.02)
        self.each(judge)

    def test_the_robot_is_told(self):
        def judge(run, frames, left, condition):
            told = {(name, active): (at_s, reaction) for _, name, reaction, active, _, at_s in run.events
                    if name not in ("late", "link full", "unpaired")}
            self.assertEqual(set(told), {(condition, 0), (condition, 1)}, run.log)
            alone = [frame.middle_s for frame in frames if frame.sensors == left]
            self.assertLessEqual(told[condition, 1][0] - alone[0], TOLD_S)
            self.assertEqual(told[condition, 1][1], SLOW)
            self.assertLessEqual(told[condition, 0][0] - alone[-1], TOLD_S)
        self.each(judge)

    def test_a_camera_that_hangs_is_opened_again(self):
        for fault, left, condition in HANGS:
            with self.subTest(fault):
                run = self.hangs[fault]
                frames = [frame for frame in run.frames if frame.whole]
                sensors = [frame.sensors for frame in frames]
                alone = [frame for frame in frames if frame.sensors == left]
                skipped = frames[-1].skipped
                self.assertEqual(sensors, [BOTH] * sensors.index(left) + [left] * len(alone)
                                 + [BOTH] * (len(sensors) - sensors.index(left) - len(alone)), run.log)
                self.assertLessEqual(len(alone), 6 + skipped, run.log)
                self.assertGreaterEqual(sensors[::-1].index(left), EDGES, "it would still be frozen")
                told = [at_s for _, name, _, active, _, at_s in run.events if (name, active) == (condition, 1)]
                self.assertEqual(len(told), 1)
                self.assertLessEqual(told[0] - alone[0].middle_s, TOLD_S)
                for before, after in zip(frames, frames[1:]):
                    self.assertGreater(after.freshness, before.freshness)

    def test_the_log_says_it(self):
        def judge(run, _, left, __):
            alone = "the stereo pair alone" if left == STEREO else "the PMD camera alone"
            self.assertIn("frames stand on " + alone, run.log)
            self.assertIn("frames stand on both sensors", run.log)
        self.each(judge)

    def test_with_both_required_the_robot_stops(self):
        for fault, run in self.strict.items():
            with self.subTest(fault):
                self.assertEqual({frame.sensors for frame in run.frames}, {BOTH}, run.log)
                begun = [at_s for _, name, reaction, active, _, at_s in run.events
                         if (name, reaction, active) == ("no frames", STOP, 1)]
                gap, last = max((after.middle_s - before.middle_s, before.middle_s)
                                for before, after in zip(run.frames, run.frames[1:]))
                self.assertGreaterEqual(gap, EDGES * PERIOD_S)
                self.assertTrue(any(0 < at_s - last <= TOLD_S + PERIOD_S for at_s in begun), run.log)


if __name__ == "__main__":
    COMMAND.extend(sys.argv[sys.argv.index("--") + 1 :])
    unittest.main(argv=sys.argv[:1], verbosity=2)
