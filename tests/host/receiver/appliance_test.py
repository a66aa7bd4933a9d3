#!/usr/bin/env python3
"""appliance_test.py -- STOFD...: tests/host/receiver/receiver.py subscribes to the appliance and gets what it sends.

More than 1,000 packets, all streams in all codecs, with and without parity: not one is refused or missing.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import time
import unittest

COMMAND = []
RECEIVER = pathlib.Path(__file__).resolve().parent / "receiver.py"
STREAMS = ("depth", "width", "source", "disparity", "pmd_raw", "grey_left", "grey_right")
TILE, FRAME_INFO, CALIBRATION, HEALTH, PARITY = "1", "2", "64", "65", "66"
LEAST_PACKETS = 1000


class PlainReceiver(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.port_file = pathlib.Path(folder.name, "port")

    def start_sensor(self, *settings):
        arguments = ["--size", "64x48", "--pmd", "32x24", "--period-ms", "40", "--port", "0", "--port-file",
                     str(self.port_file)]
        for setting in ("discovery.mdns=false", "discovery.beacon=false", *settings):
            arguments += ["--set", setting]
        sensor = subprocess.Popen([*COMMAND, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, text=True)
        self.addCleanup(self.stop, sensor)
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline and sensor.poll() is None:
            if self.port_file.exists() and self.port_file.read_text().endswith("\n"):
                return int(self.port_file.read_text())
            time.sleep(0.02)
        raise AssertionError(f"stofd did not start: {sensor.poll()}")

    @staticmethod
    def stop(sensor):
        sensor.terminate()
        sensor.communicate(timeout=60)

    def receive(self, port, frames, *more):
        """(lines of frames, other lines, packets by type)"""
        ended = subprocess.run([sys.executable, "-B", str(RECEIVER), "--sensor", f"127.0.0.1:{port}", "--frames",
                                str(frames), "--seconds", "100", "--reports", *more], capture_output=True, text=True, timeout=200)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""), ended.stdout)
        lines = ended.stdout.splitlines()
        taken = lines[-1].removeprefix("taken by type ").split()
        return ([line for line in lines if line.startswith("frame ")], lines,
                dict(zip(taken[::2], map(int, taken[1::2]))))

    def judge(self, port, frames):
        seen, lines, taken = self.receive(port, frames)
        self.assertEqual(len(seen), frames)
        self.assertIn("refused ", lines[-2:])
        for line in seen:
            arrived, count = re.search(r" packets (\d+)/(\d+) crc ", line).groups()
            self.assertEqual(arrived, count, line)
        numbers = [int(line.split()[1]) for line in seen]
        self.assertEqual(numbers, list(range(numbers[0], numbers[0] + frames)))
        self.assertGreaterEqual(taken[HEALTH], 1)
        self.assertGreaterEqual(taken[CALIBRATION], 1)
        self.assertGreaterEqual(sum(taken.values()), LEAST_PACKETS)
        return taken

    def test_gets_all_streams_coded_and_parity(self):
        port = self.start_sensor(*(f"streams.{name}=rvl" for name in STREAMS), "streams.cloud=on", "streams.parity=true")
        taken = self.judge(port, 60)
        self.assertGreaterEqual(taken[PARITY], 60)

    def test_gets_all_streams_raw(self):
        port = self.start_sensor(*(f"streams.{name}=raw" for name in STREAMS))
        taken = self.judge(port, 40)
        self.assertNotIn(PARITY, taken)

    def test_raw_pictures_are_those_that_the_frame_was_made_of(self):
        """This rig's pictures are rectified as they come: the frame's own streams are the same pixels."""
        port = self.start_sensor("streams.depth=off", "streams.width=off", "streams.source=off", "streams.pmd_raw=raw", "streams.grey_left=raw",
                                 "streams.grey_right=raw")
        seen, lines, taken = self.receive(port, 30, "--raw", "15", "--raw-every", "2")
        frames = {line.split()[1]: line.split()[-1] for line in seen}
        exposures = [line.split() for line in lines if line.startswith("raw ")]
        self.assertGreaterEqual(len(exposures), 10)
        # The receiver ends with its last frame, perhaps in the middle of an exposure.
        for exposure in exposures[:-1]:
            self.assertEqual(exposure[-4:-2], ["64x48", "64x48"])
            self.assertEqual(exposure[-5], "32x96")
        of_frames = [exposure for exposure in exposures if exposure[4] in frames and "missing" not in exposure]
        same = [exposure for exposure in of_frames if frames[exposure[4]] == exposure[-1]]
        others = [exposure for exposure in of_frames if frames[exposure[4]] != exposure[-1]]
        self.assertEqual(others, [])
        self.assertGreaterEqual(len(same), 10)
        self.assertEqual(taken["70"], int(exposures[-1][6]) - int(exposures[0][6]) + 1)
        self.assertIn("refused ", lines[-2:])

    def test_the_lease_is_kept_alive(self):
        port = self.start_sensor("streams.source=off", "streams.width=off", "period_ms=100")
        # 45 frames at 10 Hz are longer than the lease of 3 s.
        seen, _, _ = self.receive(port, 45)
        self.assertEqual(len(seen), 45)


if __name__ == "__main__":
    COMMAND.extend(sys.argv[sys.argv.index("--") + 1 :])
    unittest.main(argv=sys.argv[:1], verbosity=2)
