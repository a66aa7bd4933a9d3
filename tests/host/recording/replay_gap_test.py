#!/usr/bin/env python3
"""replay_gap_test.py COMMAND...: what recordings with a silence and with a restart in them tell, and what stof replay makes of them
(COMMAND is stof, with an emulator before it in a cross build). STOFD holds the command of stofd, its words separated by |."""

import csv
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from udp_ports import lasting_port  # noqa: E402

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
LONG_S = 240
SILENCE_S = 3.5


def wait_for_port(file, process):
    for _ in range(LONG_S * 10):
        if file.is_file() and file.read_text().strip():
            return file.read_text().strip()
        if process.poll() is not None:
            break
        time.sleep(0.1)
    raise AssertionError("did not start: " + str(process.args))


class Gaps(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(scratch.cleanup)
        cls.folder = pathlib.Path(scratch.name)
        silent, restarted = cls.begin("silent"), cls.begin("restarted")
        cls.wait_for_frames(silent)
        cls.wait_for_frames(restarted)
        silent.sensor.send_signal(signal.SIGSTOP)
        restarted.sensor.kill()
        restarted.sensor.wait()
        time.sleep(SILENCE_S)
        silent.sensor.send_signal(signal.SIGCONT)
        restarted.sensor = cls.start_sensor("again", restarted.port)[0]
        for one in (silent, restarted):
            cls.wait_for_frames(one)
            one.recording.send_signal(signal.SIGINT)
            one.recording.communicate(timeout=LONG_S)
            one.sensor.kill()

    @classmethod
    def begin(cls, name):
        one = type("One", (), {})()
        one.sensor, one.port = cls.start_sensor(name, str(lasting_port()))
        one.recording = subprocess.Popen([*COMMAND, "record", "127.0.0.1:" + one.port, f"{name}.mcap", "--timeout", "60"], cwd=cls.folder,
                                         stdout=subprocess.PIPE, text=True)
        cls.addClassCleanup(one.recording.wait)
        cls.addClassCleanup(one.recording.kill)
        return one

    @classmethod
    def start_sensor(cls, name, port):
        file = cls.folder / f"{name}.port"
        sensor = subprocess.Popen([*STOFD, "--port", port, "--port-file", str(file), "--period-ms", "200", "--size", "64x48", "--pmd", "44x36"],
                                  cwd=cls.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.addClassCleanup(sensor.wait)
        cls.addClassCleanup(sensor.kill)
        return sensor, wait_for_port(file, sensor)

    @staticmethod
    def wait_for_frames(one):
        """Some seconds of them, with health."""
        begun = None
        for line in one.recording.stdout:
            if "frames recorded" in line:
                begun = begun or int(line.split()[0])
                if int(line.split()[0]) >= begun + 8:
                    return
        raise AssertionError("it ended")

    @classmethod
    def stof(cls, *arguments):
        return subprocess.run([*COMMAND, *map(str, arguments)], cwd=cls.folder, capture_output=True, text=True, timeout=LONG_S, check=False)

    def told_of_replay(self, name, rate, *client):
        """What the client's command says of it, and what the replay does."""
        port = self.folder / f"replay_{name}_{rate}_{client[0]}.port"
        player = subprocess.Popen([*COMMAND, "replay", f"{name}.mcap", "--port", "0", "--port-file", str(port), "--rate", str(rate), "--json",
                                   "--timeout", str(LONG_S)], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(player.wait)
        self.addCleanup(player.kill)
        place = "127.0.0.1:" + wait_for_port(port, player)
        told = self.stof(client[0], place, *client[1:])
        out, errors = player.communicate(timeout=LONG_S)
        self.assertNotIn("packets that no sensor can have sent", told.stdout)
        self.assertEqual(told.returncode, 1, "it goes on until nothing comes any more")
        return told, json.loads(out), errors

    def table(self, name, kind):
        folder = self.folder / f"{name}_csv"
        if not folder.exists():
            self.assertEqual(self.stof("export", f"{name}.mcap", "--to", folder, "--as", "csv").returncode, 0)
        with open(folder / f"{kind}.csv", encoding="ascii", newline="") as rows:
            return [{key: value for key, value in row.items() if key != "log_time_ns"} for row in csv.DictReader(rows)]

    def test_silences_of_a_recording_are_counted(self):
        for name, restarts in (("silent", 0), ("restarted", 1)):
            told = json.loads(self.stof("stats", f"{name}.mcap", "--json").stdout)
            self.assertGreaterEqual(told["silences"], 1)
            self.assertEqual(told["restarts"], restarts)
            self.assertGreater(told["interval_ms"]["longest"], 1e3 * SILENCE_S * 0.8)
            checked = self.stof("check", f"{name}.mcap", "--json")
            link = next(one for one in json.loads(checked.stdout)["checks"] if one["name"] == "link")
            self.assertEqual((checked.returncode, link["verdict"]), (1, "fix"))
            self.assertRegex(link["found"], r"\d times? silent")

    def test_a_silence_is_played_as_one_and_raises_no_alarm(self):
        # The sensor may have been stopped within a frame, of which the rest came too late.
        torn = json.loads(self.stof("info", "silent.mcap", "--json").stdout)["incomplete_frames"]
        for rate in (1, 3):
            told, sent, errors = self.told_of_replay("silent", rate, "stats", "--seconds", LONG_S, "--timeout", "6", "--json")
            counts = json.loads(told.stdout)
            self.assertEqual(sent["frames_not_whole"], torn)
            self.assertEqual(errors == "", torn == 0, errors)
            self.assertEqual(counts["packets"]["implausible"], 0, f"rate {rate}")
            self.assertEqual((counts["packets"]["late"], counts["restarts"]), (0, 0))
            if rate == 1:
                self.assertGreaterEqual(counts["silences"], 1)

    def test_a_restart_is_played_with_what_both_sessions_said(self):
        recorded = self.table("restarted", "health")
        uptimes = [int(row["uptime_ms"]) for row in recorded]
        starts = [k for k in range(1, len(uptimes)) if uptimes[k] < uptimes[k - 1]]
        self.assertEqual(len(starts), 1, uptimes)
        for session in (uptimes[:starts[0]], uptimes[starts[0]:]):
            self.assertEqual(len(set(session)), len(session), "each once")
        for rate in (1, 3):
            copy = f"copy_{rate}"
            told, sent, _ = self.told_of_replay("restarted", rate, "record", f"{copy}.mcap", "--timeout", "6")
            self.assertEqual(sent["health"], len(recorded))
            self.assertEqual(sent["events"], len(self.table("restarted", "events")))
            self.assertNotIn("dropped", told.stdout)
            self.assertIn("a recording was played, which is over", told.stderr)
            self.assertEqual(self.table(copy, "events"), self.table("restarted", "events"))
            self.assertEqual([int(row["uptime_ms"]) for row in self.table(copy, "health")], uptimes)


if __name__ == "__main__":
    COMMAND = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
