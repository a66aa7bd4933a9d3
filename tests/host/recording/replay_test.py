#!/usr/bin/env python3
"""replay_test.py COMMAND...: stof record --raw, stofd --replay and stof replay (COMMAND is stof, with an emulator before it
in a cross build) as a user runs them. STOFD holds the command of stofd, its words separated by |."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
FRAMES = 16
LONG_S = 240


def wait_for_port(file, process):
    for _ in range(LONG_S * 10):
        if file.is_file() and file.read_text().strip():
            return file.read_text().strip()
        if process.poll() is not None:
            break
        time.sleep(0.1)
    raise AssertionError("did not start: " + str(process.args))


class Replay(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(cls.scratch.cleanup)
        cls.folder = pathlib.Path(cls.scratch.name)
        cls.recording = cls.folder / "raw.mcap"
        # A machine with more to do leaves exposures out, which the recording tells: then a slower sensor is asked.
        for period in (150, 400, 1000, 2500):
            cls.ended = cls.record(period)
            whole = cls.ended.returncode == 0
            if whole and json.loads(cls.stof("info", cls.recording, "--json").stdout)["incomplete_frames"] == 0:
                return
        raise AssertionError("no recording without a loss: " + cls.ended.stderr)

    @classmethod
    def record(cls, period):
        port = cls.folder / f"sensor_{period}.port"
        sensor = subprocess.Popen([*STOFD, "--port", "0", "--port-file", str(port), "--period-ms", str(period), "--temporal", "--size", "64x48",
                                   "--pmd", "44x36"], cwd=cls.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            place = "127.0.0.1:" + wait_for_port(port, sensor)
            changed = threading.Timer(3 + FRAMES * period / 2000, cls.stof, ("config", place, "set", "depth.max_range_mm=5000"))
            changed.start()
            ended = cls.stof("record", place, cls.recording, "--raw", "--frames", FRAMES, "--json", "--force", "--timeout", 60)
            changed.join()
            return ended
        finally:
            sensor.kill()
            sensor.wait()

    @classmethod
    def stof(cls, *arguments):
        return subprocess.run([*COMMAND, *map(str, arguments)], cwd=cls.folder, capture_output=True, text=True, timeout=LONG_S, check=False)

    def replay(self, *arguments):
        return subprocess.run([*STOFD, "--replay", str(self.recording), "--free-run", "--port", "0", *arguments], cwd=self.folder, capture_output=True,
                              text=True, timeout=LONG_S, check=False)

    def test_recording_tells_what_it_holds(self):
        told = json.loads(self.ended.stdout)
        self.assertEqual((told["raw_exposures"], told["raw_incomplete"]), (FRAMES, 0))
        info = json.loads(self.stof("info", self.recording, "--json").stdout)
        text = json.dumps(info)
        for name in ("/stof/raw/edge", "/stof/raw/left", "/stof/raw/right", "/stof/raw/pmd", "/stof/settings", "calibration.cal", "settings.json"):
            self.assertIn(name, text)

    def test_depth_is_computed_again_bit_for_bit(self):
        again = self.replay()
        self.assertEqual(again.returncode, 0, again.stdout + again.stderr)
        self.assertIn(f"{FRAMES} frames equal the recorded depth, 0 differ", again.stdout + again.stderr)
        self.assertIn("match not measured, convert not measured, fuse not measured", again.stdout + again.stderr)

    def test_what_a_paced_replay_does_not_measure_is_no_number(self):
        port = self.folder / "paced.port"
        player = subprocess.Popen([*STOFD, "--replay", str(self.recording), "--port", "0", "--port-file", str(port)], cwd=self.folder,
                                  stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(player.wait)
        self.addCleanup(player.kill)
        told = self.stof("stats", "127.0.0.1:" + wait_for_port(port, player), "--seconds", 1, "--timeout", 60, "--json")
        figures = json.loads(told.stdout)
        self.assertGreater(figures["received_frames"], 1)
        self.assertEqual((figures["sensor_latency_ms"], figures["compute_ms"]), (None, None))

    def test_other_settings_are_found_to_differ(self):
        other = self.replay("--disparities", "4")
        self.assertEqual(other.returncode, 1, other.stdout + other.stderr)
        self.assertNotIn(", 0 differ", other.stdout + other.stderr)

    def test_bad_files_are_refused(self):
        for file in (self.folder / "none.mcap", self.folder):
            bad = subprocess.run([*STOFD, "--replay", str(file), "--port", "0"], capture_output=True, text=True, timeout=LONG_S, check=False)
            self.assertEqual(bad.returncode, 2, bad.stderr)
            self.assertEqual(bad.stderr.count("\n"), 1, bad.stderr)
            self.assertEqual(self.stof("replay", file, "--port", 0).returncode, 2)

    def test_frames_reach_a_client_and_are_told_to_be_old(self):
        port = self.folder / "replay.port"
        player = subprocess.Popen([*COMMAND, "replay", str(self.recording), "--port", "0", "--port-file", str(port), "--rate", "0.5", "--json",
                                   "--loop", "--timeout", str(LONG_S)], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        copy = self.folder / "copy.mcap"
        try:
            place = "127.0.0.1:" + wait_for_port(port, player)
            recorded = self.stof("record", place, copy, "--frames", FRAMES, "--timeout", 60)
            player.send_signal(signal.SIGINT)
            out, errors = player.communicate(timeout=LONG_S)
        finally:
            player.kill()
            player.communicate()
        self.assertEqual(recorded.returncode, 0, recorded.stderr)
        self.assertIn("REPLAY", recorded.stdout)
        self.assertEqual(player.returncode, 0, errors)
        self.assertGreaterEqual(json.loads(out)["frames"], FRAMES)
        before, after = (json.loads(self.stof("info", file, "--json").stdout)["sensor"] for file in (self.recording, copy))
        self.assertEqual(after["device_id"], before["device_id"])
        self.assertNotEqual(after["session_id"], before["session_id"])
        self.assertIn("recording", after["sensor_clock"])
        for file in (self.recording, copy):
            self.assertEqual(self.stof("export", file, "--to", file.with_suffix(""), "--as", "png16").returncode, 0)
        # What a busy machine reads too late the client leaves out; the next pass brings it.
        before, after = ([one.read_bytes() for one in file.with_suffix("").glob("**/*.png")] for file in (self.recording, copy))
        self.assertEqual(len(after), FRAMES)
        self.assertLessEqual(set(after), set(before))
        self.assertGreater(len(set(after)), 1)

    def test_output_that_cannot_be_written_is_told(self):
        if not pathlib.Path("/dev/full").exists():
            self.skipTest("no /dev/full")
        for arguments in (("info", self.recording, "--json"), ("recover", self.recording, "--json"), ("replay", "--help")):
            with open("/dev/full", "w", encoding="utf-8") as full:
                ended = subprocess.run([*COMMAND, *map(str, arguments)], stdout=full, stderr=subprocess.PIPE, text=True, timeout=LONG_S, check=False)
            self.assertEqual(ended.returncode, 1, arguments)
            self.assertIn("cannot be written", ended.stderr)

    def sensor(self, name, *more):
        port = self.folder / f"{name}.port"
        sensor = subprocess.Popen([*STOFD, "--port", "0", "--port-file", str(port), "--period-ms", "400", "--size", "64x48", "--pmd", "44x36", *more],
                                  cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(sensor.wait)
        self.addCleanup(sensor.kill)
        return "127.0.0.1:" + wait_for_port(port, sensor)

    def test_pictures_of_one_camera_are_kept_where_the_other_is_gone(self):
        faults = str(self.folder / "faults")
        place = self.sensor("one_eyed", "--fault-socket", faults)
        file = self.folder / "one_eyed.mcap"
        recording = subprocess.Popen([*COMMAND, "record", place, str(file), "--raw", "--frames", "24", "--timeout", "60"], cwd=self.folder,
                                     stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        said = []
        for line in recording.stdout:
            said.append(line)
            if " 0 with raw pictures" not in line and "with raw pictures" in line:
                break
        self.assertEqual(self.stof("fault", faults, "pmd:vanish:8").returncode, 0)
        rest, errors = recording.communicate(timeout=LONG_S)
        said = "".join(said) + rest
        self.assertRegex(said, r"\d+ exposures lack what a camera did not give", errors)
        counts = {one["topic"]: one["messages"] for one in json.loads(self.stof("info", file, "--json").stdout)["channels"]}
        self.assertGreaterEqual(counts["/stof/raw/left"] - counts["/stof/raw/pmd"], 4, counts)

    def test_raw_pictures_that_are_denied_end_at_once_and_leave_no_file(self):
        self.assertEqual(self.stof("pair", "--into", "sensor.keys", "--keys", "user.keys").returncode, 0)
        place = self.sensor("paired", "--keys", "sensor.keys")
        file = self.folder / "denied.mcap"
        for _ in range(2):  # nothing is in the way of another try
            ended = self.stof("record", place, file, "--raw", "--frames", 3, "--timeout", 60)
            self.assertEqual(ended.returncode, 1, ended.stdout)
            self.assertIn("--signed", ended.stderr)
            self.assertNotIn("--raw-every", ended.stderr)
            self.assertFalse(file.exists())

    def test_frames_that_are_not_whole_are_no_replay(self):
        place = self.sensor("lossy")
        port = self.folder / "proxy.port"
        proxy = subprocess.Popen([*COMMAND, "proxy", "--listen", "0", "--to", place, "--loss", "50", "--only", "down", "--port-file", str(port)],
                                 cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(proxy.wait)
        self.addCleanup(proxy.kill)
        through = "127.0.0.1:" + wait_for_port(port, proxy)
        file = self.folder / "torn.mcap"
        for _ in range(30):
            self.stof("record", through, file, "--frames", 1, "--force", "--timeout", 60)
            info = json.loads(self.stof("info", file, "--json").stdout)
            if info["frames"] == info["incomplete_frames"]:
                break
        ended = self.stof("replay", file, "--port", 0, "--timeout", 1)
        self.assertEqual(ended.returncode, 2, ended.stdout)
        self.assertIn("none of its frames was received as a whole", ended.stderr)

    def test_nobody_comes(self):
        ended = self.stof("replay", self.recording, "--port", 0, "--timeout", 1, "--json")
        self.assertEqual(ended.returncode, 1)
        self.assertEqual(json.loads(ended.stdout)["frames"], 0)
        self.assertIn("nobody subscribed", ended.stderr)


if __name__ == "__main__":
    COMMAND = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
