#!/usr/bin/env python3
"""verbs_test.py -- COMMAND...: every command of `stof` (COMMAND, with an emulator before it in a cross build) with a sensor, with one that
is not there or goes, with a recording and on a full disk: exit codes and JSON. STOFD holds the command of stofd, its words separated
by |. Where this machine lets us, in a network of its own, so that sensors may have their usual port."""

import ctypes
import fcntl
import json
import os
import pathlib
import re
import resource
import signal
import socket
import struct
import subprocess
import sys
import tarfile
import threading
import time
import unittest

import verbs
from verbs import LONG, TALKERS, VERBS

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from udp_ports import lasting_port  # noqa: E402

STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
OWN_NETWORK = False
ENOUGH_S = 120


@unittest.skipUnless(STOFD, "no stofd in this build")
class Sensors(verbs.Program):
    """One emulated sensor for all."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.running, cls.place = cls.start_sensor("sensor", "--name", "front", *(["--port", "7560"] if OWN_NETWORK else ["--port", "0"]))
        cls.recording = cls.folder / "whole.mcap"
        ended = cls.stof("record", cls.place, cls.recording, "--frames", 12, *LONG.split())
        assert ended.returncode == 0, ended.stderr

    @classmethod
    def start_sensor(cls, name, *more):
        file = cls.folder / f"{name}.port"
        file.unlink(missing_ok=True)
        sensor = subprocess.Popen([*STOFD, "--port-file", str(file), "--period-ms", "150", "--size", "64x48", "--pmd", "44x36", *more],
                                  cwd=cls.folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        cls.addClassCleanup(sensor.wait)
        cls.addClassCleanup(sensor.kill)
        for _ in range(10 * ENOUGH_S):
            if file.is_file() and file.read_text().endswith("\n"):
                return sensor, "127.0.0.1:" + file.read_text().strip()
            if sensor.poll() is not None:
                break
            time.sleep(0.1)
        raise AssertionError("stofd did not start")

    def answered(self, *words):
        """JSON of a command that looks for a sensor some seconds, which may be too few on a busy computer."""
        end = time.monotonic() + ENOUGH_S
        while (ended := self.stof(*words)).returncode != 0 and time.monotonic() < end:
            pass
        self.assertEqual(ended.returncode, 0, ended.stderr)
        return json.loads(ended.stdout)

    def test_nobody_there_ends_with_the_documented_code(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as silent:
            silent.bind(("127.0.0.1", 0))
            place = f"127.0.0.1:{silent.getsockname()[1]}"
            for name, verb in VERBS.items():
                if verb.lost is not None:
                    with self.subTest(name):
                        ended = self.stof(*self.words_of(name, s=place), *([] if name in TALKERS else ["--json"]))
                        self.refused(ended, verb.lost, place)
                        if name not in TALKERS:
                            self.nothing_but_json(ended)
        self.assertEqual([left.name for left in self.folder.glob("new*")], ["new.tar"])  # a report says why nobody is there

    def test_json_of_a_sensor_parses(self):
        for name, verb in VERBS.items():
            for words in verb.live:
                with self.subTest(f"{name} {words}"):
                    end = time.monotonic() + ENOUGH_S
                    ended = self.stof(*name.split(), *words.format(s=self.place).split())
                    # These wait for an answer as long as they were told to, and no longer.
                    while name in ("discover", "config") and ended.returncode != 0 and time.monotonic() < end:
                        ended = self.stof(*name.split(), *words.format(s=self.place).split())
                    # A check may find what has to be mended on a busy computer: then it says so.
                    self.assertIn(ended.returncode, (0, 1) if name == "check" else (0,), ended.stderr)
                    self.assertTrue(json.loads(ended.stdout))

    def test_json_of_a_recording_parses(self):
        for name, verb in VERBS.items():
            for words in verb.file:
                with self.subTest(f"{name} {words}"):
                    ended = self.stof(*name.split(), *words.format(f=self.recording).split())
                    # Nobody subscribes to the replay.
                    self.assertIn(ended.returncode, {"check": (0, 1), "replay": (1,)}.get(name, (0,)), ended.stderr)
                    self.assertTrue(json.loads(ended.stdout))

    def test_what_a_sensor_is_and_how_it_is(self):
        end = time.monotonic() + ENOUGH_S
        while True:
            info = json.loads(self.stof("info", self.place, "--json", *LONG.split()).stdout)
            # What a busy sensor does not answer within a second is left out.
            if (info["identity"] and info["settings"] and info["calibration"]) or time.monotonic() > end:
                break
        self.assertEqual((info["identity"]["serial"], info["identity"]["name"], info["device_id"]), ("00000001", "front", 1))
        self.assertEqual(info["settings"]["period_ms"], 150)
        self.assertEqual((info["calibration"]["width"], info["calibration"]["height"]), (64, 48))
        health = json.loads(self.stof("health", self.place, "--json", *LONG.split()).stdout)
        self.assertGreaterEqual(health["age_s"], 0)
        [unpaired] = [one for one in health["conditions"] if one["name"] == "unpaired"]
        self.assertEqual((unpaired["severity"], unpaired["reaction"]), ("info", "none"))
        self.assertIn("no key is known", unpaired["text"])
        text = self.stof("health", self.place, *LONG.split()).stdout
        self.assertIn("unpaired: no key is known", text)
        self.assertRegex(text, r"\d\.\d s old")
        checks = {one["name"]: one for one in json.loads(self.stof("check", self.place, "--seconds", "0.5", "--json", *LONG.split()).stdout)["checks"]}
        self.assertEqual(list(checks), ["reach", "firewall", "mtu", "buffers", "link", "clock", "calibration", "health", "key", "version"])
        for name in ("reach", "mtu", "calibration"):
            self.assertEqual(checks[name]["verdict"], "ok", checks[name])
        self.assertEqual((checks["key"]["verdict"], checks["key"]["fix"]), ("note", f"stof pair {self.place}"))
        for one in checks.values():
            self.assertNotIn("\n", one["found"] + (one["fix"] or ""))
            self.assertTrue(one["verdict"] != "fix" or one["fix"], one)

    def test_a_report_holds_what_whoever_helps_asks_for_and_no_key(self):
        wanted = {"about.txt", "check.txt", "check.json", "health.json", "stats.json", "info.json", "settings_active.json",
                  "settings_saved.json", "settings_defaults.json", "calibration.cal", "computer.json", "events.txt", "frame/depth.png"}
        end = time.monotonic() + ENOUGH_S
        again = []
        while True:
            ended = self.stof("report", self.place, "support.tar", "--seconds", "0.5", *again, *LONG.split())
            self.assertEqual(ended.returncode, 0, ended.stderr)
            with tarfile.open(self.folder / "support.tar") as tar:
                files = {one.name.removeprefix("stof-report/"): tar.extractfile(one).read() for one in tar.getmembers()}
            # What a busy sensor does not answer within a second is told in its place.
            settings = [data for name, data in files.items() if name.startswith("settings_")]
            if (wanted <= set(files) and all(data.startswith(b"{") for data in settings)) or time.monotonic() > end:
                break
            again = ["--force"]
        self.assertLessEqual(wanted, set(files))
        for name, data in files.items():
            if name.endswith(".json"):
                json.loads(data)
        self.assertFalse(any("key" in name for name in files))
        self.refused(self.stof("report", self.place, "support.tar"), 2, "support.tar", "--force")
        told = json.loads(self.stof("report", self.recording, "recorded.tar", "--json").stdout)
        self.assertLessEqual({"settings_recorded.json", "events.txt", "frame/depth.png", "info.json"}, set(told["files"]))
        plain = self.stof("report", self.place, "plain.tar", "--seconds", "0.5", "--no-pictures", *LONG.split())
        self.assertEqual(plain.returncode, 0, plain.stderr)
        with tarfile.open(self.folder / "plain.tar") as tar:
            self.assertFalse([name for name in tar.getnames() if "/frame/" in name])

    def test_a_full_disk_ends_with_the_documented_code(self):
        def no_room():
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

        for words in (["record", self.place, "full.mcap", "--frames", 2], ["export", self.recording, "--to", "full", "--as", "ply"],
                      ["export", self.place, "--to", "full_live", "--as", "ply", "--frames", 1],
                      ["report", self.place, "full.tar", "--seconds", "0.5"]):
            with self.subTest(words[0]):
                self.refused(self.stof(*words, *([] if words[1] == self.recording else LONG.split()), preexec_fn=no_room), 1)
        # Nobody takes a part for a cloud.
        self.assertEqual([file for name in ("full", "full_live") for file in (self.folder / name).glob("*")], [])
        self.refused(self.stof("recover", self.recording, "full_copy.mcap", preexec_fn=no_room), 2)
        self.refused(self.stof("report", self.place, "/dev/full", "--force"), 1, "/dev/full")

    def test_a_reader_that_goes_away_is_output_that_cannot_be_written(self):
        for words in (["stats", self.place, "--json", "--seconds", "0.5"], ["record", self.place, "unread.mcap", *LONG.split()]):
            with self.subTest(words[0]):
                reading, writing = os.pipe()
                os.close(reading)
                ended = self.stof(*words, stdout=writing, restore_signals=True)
                os.close(writing)
                self.refused(ended, 1, "its output cannot be written", "whoever read it has gone")
        self.assertFalse((self.folder / "unread.mcap").exists(), "nothing was recorded")

    def test_a_number_is_no_address(self):
        if not OWN_NETWORK:
            self.skipTest("no network of our own here")
        self.refused(self.stof("health", "2"), 2, "no sensor near has that serial number")

    def test_json_is_of_what_is_there(self):
        nobody = self.stof("record", "127.0.0.1:9", "nobody.mcap", "--json", "--timeout", "0.4")
        self.refused(nobody, 1, "no frame came")
        self.assertEqual(nobody.stdout, "")

        def no_room():
            resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))

        full = self.stof("record", self.place, "little.mcap", "--frames", 50, "--json", *LONG.split(), preexec_fn=no_room)
        self.refused(full, 1, "no frame was kept")
        self.assertEqual(full.stdout, "")
        full = self.stof("record", self.place, "little.mcap", "--frames", 50, *LONG.split(), preexec_fn=no_room)
        self.assertNotIn("wrote little.mcap", full.stdout)
        self.refused(self.stof("recover", self.recording, "little.mcap", preexec_fn=no_room), 2)
        self.assertFalse((self.folder / "little.mcap").exists(), "all of it is in the recording still")

    def test_an_export_that_ends_early_tells_what_is_there(self):
        for how, names in (("png16", "*.png"), ("tum", "depth/*.png")):
            with self.subTest(how):
                folder = self.folder / f"early_{how}"
                self.assertEqual(self.stof("export", self.recording, "--to", folder, "--as", how).returncode, 0)
                fifth = sorted(folder.glob(names))[4]
                for file in folder.rglob("*.*"):
                    file.unlink()
                os.mkfifo(fifth)  # is not written to
                ended = self.stof("export", self.recording, "--to", folder, "--as", how, "--json")
                self.refused(ended, 1, fifth.name)
                told = json.loads(ended.stdout)
                self.assertEqual((told["exported"], told["frames"]), (4, json.loads(self.stof("info", self.recording, "--json").stdout)["frames"]))
                if how == "tum":
                    self.assertEqual(len((folder / "depth.txt").read_text().splitlines()), 5)
        (self.folder / "early_csv").mkdir()
        os.mkfifo(self.folder / "early_csv/frames.csv")
        self.assertEqual(self.stof("export", self.recording, "--to", "early_csv", "--as", "csv", "--json").stdout, "")
        self.refused(self.stof("export", "127.0.0.1:9", "--to", "early/below", "--as", "csv", "--timeout", "0.4"), 1)
        self.assertFalse((self.folder / "early").exists())

    def test_health_without_frames_ends_what_waits_for_frames(self):
        socket_of_faults = str(self.folder / "faults")
        _, place = self.start_sensor("triggerless", "--fault-socket", socket_of_faults)
        self.assertEqual(self.stof("stats", place, "--seconds", "0.3", *LONG.split()).returncode, 0)
        self.assertEqual(self.stof("fault", socket_of_faults, "trigger:vanish").returncode, 0)
        end = time.monotonic() + ENOUGH_S
        while "trigger_lost" not in self.stof("health", place, *LONG.split()).stdout and time.monotonic() < end:
            pass
        for words in (["stats"], ["info"], ["view", "--frames", 3], ["record", "none.mcap", "--frames", 3], ["export", "--to", "none", "--as", "ply", "--frames", 2]):
            with self.subTest(words[0]):
                self.refused(self.stof(words[0], place, *words[1:], "--timeout", "3"), 1, "its health comes, and no frame", "trigger_lost")
        ended = self.stof("check", place, "--json", "--timeout", "3")
        checks = {one["name"]: one for one in json.loads(ended.stdout)["checks"]}
        self.assertEqual(ended.returncode, 1)
        self.assertEqual((checks["reach"]["fix"], checks["firewall"]["verdict"], checks["health"]["verdict"]), ("see health", "ok", "fix"))
        self.assertIn("trigger_lost", checks["health"]["found"])

    def test_a_check_says_that_the_sensor_stopped(self):
        sensor, place = self.start_sensor("stopping")
        check = subprocess.Popen([*verbs.COMMAND, "check", place, "--seconds", "6", "--timeout", "10", "--json"], cwd=self.folder, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, text=True)
        time.sleep(3)
        sensor.kill()
        sensor.wait()
        said, errors = check.communicate(timeout=240)
        checks = {one["name"]: one for one in json.loads(said)["checks"]}
        self.assertEqual(check.returncode, 1, errors)
        self.assertIn("the last one", checks["reach"]["found"])
        self.assertIn("any more", checks["reach"]["found"])
        self.assertEqual((checks["firewall"]["verdict"], checks["firewall"]["fix"]), ("ok", None))
        self.assertNotIn("1 time silent", checks["link"]["found"])

    def test_a_sensor_that_falls_silent_and_starts_again_is_told_at_once(self):
        first, place = self.start_sensor("leaving", "--port", str(lasting_port()))
        watch = subprocess.Popen([*verbs.COMMAND, "health", place, "--seconds", "600", "--timeout", "120"], cwd=self.folder,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        measure = subprocess.Popen([*verbs.COMMAND, "stats", place, "--seconds", "600", "--timeout", "15"], cwd=self.folder,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        lines, measured = Lines(watch.stdout), Lines(measure.stdout)
        for process in (watch, measure):
            self.addCleanup(process.wait)
            self.addCleanup(process.kill)
        for said, words in ((lines, "s old"), (lines, "frames of sensor 1"), (measured, "frames of sensor 1")):
            self.assertTrue(said.wait_for(words), said.text())
        first.kill()
        first.wait()
        silence = r"the sensor is silent, its last frame is \d+\.\d s old; last health \d+\.\d s ago: \w+"
        self.assertTrue(lines.wait_for(silence), lines.text())
        self.assertEqual(measure.wait(240), 1)
        errors = measure.stderr.read()
        self.assertRegex(errors, r"^stof: .*fell silent after \d+ frames, last health .* ago: check .*\n$")
        self.start_sensor("back", "--port", place.rpartition(":")[2])
        self.assertTrue(lines.wait_for("the sensor started again"), lines.text())
        watch.send_signal(signal.SIGINT)
        self.assertEqual((watch.wait(60), watch.stderr.read()), (0, ""))
        for process, said in ((watch, lines), (measure, measured)):
            said.close()
            process.stderr.close()

    def test_serial_number_and_name_are_as_good_as_the_address(self):
        if not OWN_NETWORK:
            self.skipTest("no network of our own here")
        for called in ("00000001", "front"):
            with self.subTest(called):
                self.assertEqual(self.answered("info", called, "--json", *LONG.split())["identity"]["name"], "front")
                self.assertEqual(self.answered("config", called, "get", "period_ms", "--json", "--timeout", "10"), 150)
        self.refused(self.stof("info", "rear", "--timeout", "0.4"), 2, "rear")


class Lines:
    """What a process says, as it says it."""

    def __init__(self, stream):
        self.said = []
        self.stream = stream
        self.thread = threading.Thread(target=self.read, args=(stream,), daemon=True)
        self.thread.start()

    def read(self, stream):
        for line in stream:
            self.said.append(line)

    def close(self):
        self.thread.join(60)
        self.stream.close()

    def text(self):
        return "".join(self.said)

    def wait_for(self, words, seconds=ENOUGH_S):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            for line in list(self.said):
                if re.search(words, line):
                    return line
            time.sleep(0.05)
        return ""


def enter_own_network():
    """This process and its children have a network of their own, which is a loopback interface alone; False where that may not be."""
    new_network = 0x40000000
    libc = ctypes.CDLL(None, use_errno=True)
    try:
        with open("/proc/self/ns/net", "rb") as before:
            if libc.unshare(new_network) != 0:
                return False
            try:
                with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
                    up = struct.pack("16sh14x", b"lo", 0x1 | 0x40)  # IFF_UP, IFF_RUNNING
                    fcntl.ioctl(any_socket, 0x8914, up)  # SIOCSIFFLAGS
                return True
            except OSError:  # it may make a network, and not change it
                if libc.setns(before.fileno(), new_network) != 0:
                    raise
    except FileNotFoundError:
        pass
    return False


def main():
    global OWN_NETWORK  # pylint: disable=global-statement
    verbs.COMMAND.extend(sys.argv[sys.argv.index("--") + 1:])
    OWN_NETWORK = enter_own_network()
    result = unittest.main(argv=sys.argv[:1], exit=False, verbosity=2).result
    sys.exit(0 if result.wasSuccessful() else 1)


if __name__ == "__main__":
    main()
