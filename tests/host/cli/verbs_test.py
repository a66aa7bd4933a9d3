#!/usr/bin/env python3
"""verbs_test.py PART -- COMMAND...: every command of `stof` (COMMAND, with an emulator before it in a cross build) by one table:
help with an example, unknown flags, output that cannot be written, a sensor that is not there or goes, and JSON. STOFD holds the
command of stofd, its words separated by |. Where this machine lets us, in a network of its own, so that sensors may have their usual
port. Part Words needs no sensor."""

import ctypes
import dataclasses
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
import tempfile
import threading
import time
import unittest
import unittest.mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from udp_ports import lasting_port  # noqa: E402

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
OWN_NETWORK = False
ENOUGH_S = 120


@dataclasses.dataclass(frozen=True)
class Verb:
    """words: that make a command line which is understood. {s}: a sensor. lost: its exit code where nobody answers there; None: it
    asks no sensor. live, file: words whose output is JSON, of a sensor, of a recording ({f})."""

    words: str
    lost: int | None = None
    live: tuple[str, ...] = ()
    file: tuple[str, ...] = ()


# Who has no --json. Of those that this build has not, nobody can tell.
TALKERS = {"view", "bridge ros2", "completion", "calib stereo", "calib extrinsics", "calib import", "calib export", "calib target", "evaluate chapter"}
WAIT = "--timeout 0.4"
LONG = "--timeout 60"  # of what has to come
VERBS = {
    "view": Verb(f"{{s}} {WAIT} --frames 1", lost=1),
    "record": Verb(f"{{s}} new.mcap {WAIT} --frames 1", lost=1, live=(f"{{s}} live.mcap --frames 2 --json {LONG}",)),
    "info": Verb(f"{{s}} {WAIT}", lost=1, live=(f"{{s}} --json {LONG}",), file=("{f} --json",)),
    "stats": Verb(f"{{s}} {WAIT}", lost=1, live=(f"{{s}} --seconds 0.5 --json {LONG}",), file=("{f} --json",)),
    "health": Verb(f"{{s}} {WAIT}", lost=1, live=(f"{{s}} --json {LONG}",), file=("{f} --json",)),
    "check": Verb(f"{{s}} {WAIT}", lost=1, live=(f"{{s}} --seconds 0.5 --json {LONG}",), file=("{f} --json",)),
    "report": Verb(f"{{s}} new.tar {WAIT}", lost=1, live=(f"{{s}} live.tar --seconds 0.5 --json {LONG}",), file=("{f} file.tar --json",)),
    "export": Verb(f"{{s}} --to new --as csv {WAIT}", lost=1, live=(f"{{s}} --to live --as tum --frames 2 --json {LONG}",),
                   file=("{f} --to file --as ply --json",)),
    "recover": Verb("absent.mcap", file=("{f} --json",)),
    "replay": Verb("absent.mcap", file=("{f} --port 0 --bind 127.0.0.1 --timeout 0.2 --json",)),
    "fault": Verb("absent.socket pmd:vanish:60"),
    "bridge ros2": Verb("absent.mcap"),
    "discover": Verb("--timeout 0.3", live=("--timeout 4 --address {s} --json",)),
    "address": Verb("{s} 192.168.7.2/24 --timeout 0.05 --keys keys", lost=1),
    "config": Verb("{s} get --timeout 0.05", lost=1, live=("{s} get --json --timeout 10", "{s} diff --json --timeout 10", "{s} schema --timeout 10")),
    "pair": Verb("{s} --timeout 0.05 --keys keys --digits 123456", lost=1),
    "unpair": Verb("{s} --timeout 0.05 --keys mine --list", lost=1),
    "update": Verb("{s} absent.update --timeout 0.05 --keys keys"),
    "proxy": Verb("--listen 0 --to {s}"),
    "completion": Verb("bash"),
    "calib pmd": Verb("absent --out new.cal"),
    "calib install": Verb("absent.cal {s} --timeout 0.05 --keys keys"),
    "calib stereo": Verb("--planes absent --out new.cal"),
    "calib extrinsics": Verb("absent --calibration absent.cal --out new.cal"),
    "calib check": Verb("absent --calibration absent.cal"),
    "calib import": Verb("ros absent.yaml --out new.cal"),
    "calib export": Verb("ros absent.cal --out new.yaml"),
    "calib target": Verb("--out new.pdf"),
    "evaluate stereo": Verb("absent"),
    "evaluate fusion": Verb("absent absent"),
    "evaluate floor": Verb("absent"),
    "evaluate pmd": Verb("absent"),
    "evaluate sequence": Verb("absent"),
    "evaluate chapter": Verb("absent --out new.html"),
}


class Program(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scratch = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(scratch.cleanup)
        cls.folder = pathlib.Path(scratch.name)
        # Nobody's keys.
        environment = unittest.mock.patch.dict(os.environ, {"XDG_CONFIG_HOME": scratch.name})
        environment.start()
        cls.addClassCleanup(environment.stop)
        made = cls.stof("pair", "--into", "theirs", "--keys", "mine")
        assert made.returncode == 0, made.stderr

    @classmethod
    def stof(cls, *words, **more):
        return subprocess.run([*COMMAND, *map(str, words)], **{"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True,
                                                               "timeout": 240, "cwd": cls.folder, **more})

    def refused(self, ended, code, *facts):
        """It ended with the code and one line that holds all facts."""
        self.assertEqual(ended.returncode, code, f"{ended.stdout} {ended.stderr}")
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertTrue(ended.stderr.startswith("stof: "), ended.stderr)
        for fact in facts:
            self.assertIn(fact, ended.stderr)

    def nothing_but_json(self, ended):
        """Who does nothing prints nothing; else each line is a document, or all of them are one."""
        if ended.stdout:
            try:
                json.loads(ended.stdout)
            except ValueError:
                for line in ended.stdout.splitlines():
                    json.loads(line)

    def words_of(self, name, **places):
        return [*name.split(), *VERBS[name].words.format(**{"s": "127.0.0.1:9", **places}).split()]


class Words(Program):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.helps = {}
        groups = [""]
        for group in groups:
            text = cls.stof(*group.split(), "--help").stdout
            for word in re.findall(r"(?m)^  (\w\S*)", text.partition("Subcommands:")[2]):
                name = f"{group} {word}".strip()
                said = cls.stof(*name.split(), "--help")
                assert said.returncode == 0 and not said.stderr, said.stderr
                if "Subcommands:" in said.stdout:
                    groups.append(name)
                else:
                    cls.helps[name] = said.stdout
        cls.groups = [group for group in groups if group]

    def test_the_table_has_every_command(self):
        self.assertEqual(set(VERBS), set(self.helps))

    def test_help_has_an_example_whose_flags_there_are_and_the_exit_codes(self):
        for name, text in self.helps.items():
            with self.subTest(name):
                examples = re.findall(r"(?m)^Example: (.*)$", text)
                self.assertTrue(any(f"stof {name} " in example or example == f"stof {name}" for example in examples), examples)
                self.assertRegex(text, r"(?m)^Ends with 0 ")
                if "Not in this build" not in text:
                    for example in examples:
                        for flag in re.findall(r" (--[\w-]+)", example.partition("and beside it")[0]):
                            self.assertRegex(text, rf"(?m)^  (?:-\w,)?{flag}\b")

    def test_every_command_but_those_that_are_listed_has_json(self):
        without = {name for name, text in self.helps.items() if not re.search(r"(?m)^  --json\b", text) and "Not in this build" not in text}
        absent = {name for name, text in self.helps.items() if "Not in this build" in text}
        self.assertEqual(without, TALKERS - absent)

    def test_bad_input_leaves_no_broken_json(self):
        for name, text in self.helps.items():
            if VERBS[name].lost is None and name not in TALKERS and "Not in this build" not in text:
                words = [*self.words_of(name), "--json"]
                words = ["127.0.0.1:port" if name == "proxy" and word == "127.0.0.1:9" else word for word in words]
                with self.subTest(name):
                    if name == "discover":
                        words = ["discover", "--address", ":", "--json"]
                    ended = self.stof(*words)
                    self.assertEqual((ended.returncode, ended.stdout), (1 if name == "fault" else 2, ""), ended.stderr)

    def test_a_socket_of_something_else_is_told(self):
        answers = [b"", b"x", b"ok\npmd \x1b[31m 4 drop\n", b"ok\npmd none -5 drop\n"]
        with tempfile.TemporaryDirectory() as folder, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as other:
            place = f"{folder}/socket"
            other.bind(place)

            def answer_all():
                for answer in answers:
                    other.sendto(answer, other.recvfrom(1000)[1])

            answering = threading.Thread(target=answer_all, daemon=True)
            answering.start()
            for answer in answers:
                ended = self.stof("fault", place)
                self.assertEqual((ended.returncode, ended.stdout), (1, ""), answer)
                self.assertIn("no list of faults", ended.stderr)
            answering.join(ENOUGH_S)

    def test_json_of_a_new_key_parses(self):
        made = self.stof("pair", "--into", "sensor.keys", "--keys", "user.keys", "--role", "tune", "--name", "me", "--json")
        self.assertEqual((made.returncode, made.stderr), (0, ""))
        key = json.loads(made.stdout)
        self.assertRegex(key["key"], "^[0-9a-f]{8}$")
        self.assertEqual((key["device_id"], key["role"], key["name"], key["file"], key["into"]), (1, "tune", "me", "user.keys", "sensor.keys"))
        again = json.loads(self.stof("pair", "--into", "sensor.keys", "--keys", "user.keys", "--role", "tune", "--json").stdout)
        self.assertEqual((again["key"], again["into"]), (None, "sensor.keys"))
        gone = self.stof("unpair", "--forget", "--device", "1", "--keys", "user.keys", "--json")
        self.assertEqual((gone.returncode, json.loads(gone.stdout)), (0, {"forgotten": 1, "device_id": 1, "file": "user.keys"}))

    def test_a_list_of_keys_takes_a_key_of_ones_own(self):
        self.refused(self.stof("unpair", "127.0.0.1:9", "--list", "--keys", "absent"), 2, "stof pair 127.0.0.1:9")

    def test_what_is_not_there_is_not_told(self):
        """A report without a frame has no picture, a recording without a message no time."""
        ended = self.stof("report", "127.0.0.1:9", "nothing.tar", "--timeout", "0.4")
        self.assertEqual(ended.returncode, 1, ended.stderr)
        self.assertIn("without keys, with no picture", ended.stdout)
        magic = b"\x89MCAP0\r\n"
        records = [(1, struct.pack("<I4sI", 4, b"ros2", 0)), (15, bytes(4)), (2, bytes(20))]
        body = b"".join(struct.pack("<BQ", kind, len(data)) + data for kind, data in records)
        (self.folder / "empty.mcap").write_bytes(magic + body + magic)
        told = self.stof("info", "empty.mcap").stdout
        self.assertIn("no messages", told)
        self.assertNotIn("1970", told)

    def test_what_is_no_sensor_is_told_what_it_is(self):
        (self.folder / "hall.mcap").write_bytes(b"")
        (self.folder / "hall").mkdir(exist_ok=True)
        for words, what in ((["info", "."], "is a folder"), (["view", ".."], "is a folder"), (["record", "hall.mcap", "new.mcap"], "is a recording"),
                            (["config", "hall.mcap", "get"], "is a recording"), (["pair", "hall.mcap"], "is a recording"),
                            (["config", "./hall", "get"], "is a folder")):
            with self.subTest(words):
                self.refused(self.stof(*words), 2, what)
        self.assertFalse((self.folder / "new.mcap").exists())

    def test_an_unknown_flag_is_refused_in_one_line_also_with_help_behind_it(self):
        for name, text in self.helps.items():
            for behind in ([], ["--help"]) if "Not in this build" not in text else ():
                with self.subTest(f"{name} {behind}"):
                    self.refused(self.stof(*name.split(), "--nonsense", *behind), 2, "--nonsense", f"stof {name}")

    def test_a_mistyped_flag_names_the_nearest(self):
        self.refused(self.stof("info", "--jsno"), 2, "did you mean --json")
        self.refused(self.stof("view", "--time-out=3"), 2, "--time-out", "did you mean --timeout")

    def test_a_mistyped_command_names_the_nearest_also_with_help_behind_it(self):
        for name in [*self.helps, *self.groups]:
            *group, word = name.split()
            mistyped = word[:2] + word[3:]
            with self.subTest(mistyped):
                self.refused(self.stof(*group, mistyped, "--help"), 2, f'"{mistyped}"', f"did you mean {word}")
        self.refused(self.stof("nonsense", "--help"), 2, '"nonsense": stof has no such command: try stof --help')
        self.refused(self.stof("--help", "nonsense"), 2, "no such command")
        self.refused(self.stof("config", "127.0.0.1:9", "gte"), 2, "did you mean get")

    def test_output_that_cannot_be_written_is_found_before_anything_is_done(self):
        for name in self.helps:
            with self.subTest(name), open("/dev/full", "w", encoding="ascii") as full:
                self.refused(self.stof(*self.words_of(name), stdout=full), 1, "its output cannot be written")
        self.assertEqual(list(self.folder.glob("new*")), [])
        with open("/dev/full", "w", encoding="ascii") as full:
            self.refused(self.stof("--help", stdout=full), 1, "its output cannot be written")
            # What is wrong is said all the same.
            self.refused(self.stof("nonsense", stdout=full), 2, "nonsense")

    def test_files_and_folders_that_cannot_be_made_are_found_before_a_sensor_is_asked(self):
        """Nobody is there: who had asked would end with 1."""
        (self.folder / "file").write_text("")
        (self.folder / "folder").mkdir(exist_ok=True)
        for words in (["view", "--out", "file"], ["view", "--headless", "file"], ["view", "--out", "file/below"],
                      ["export", "--to", "file", "--as", "csv"], ["export", "--to", "file/below", "--as", "ply"],
                      ["record", "folder"], ["record", "file/below.mcap"], ["record", "file"],
                      ["report", "folder"], ["report", "file/below.tar"], ["report", "file"], ["report", "absent/below.tar"]):
            with self.subTest(words):
                verb, *rest = words
                self.refused(self.stof(verb, "127.0.0.1:9", "--timeout", "0.4", *rest), 2, rest[1] if rest[0].startswith("--") else rest[0])

    def test_bash_completes_every_command_every_flag_and_values(self):
        script = self.stof("completion", "bash").stdout
        asked = [(["stof", "vi"], ["view"]), (["stof", "calib", "st"], ["stereo"]), (["stof", "export", "--as", "p"], ["pcd", "ply", "png16"]),
                 (["stof", "export", "--as", "=", "p"], ["pcd", "ply", "png16"]), (["stof", "export", "--to", ""], []),
                 (["stof", "completion", "ba"], ["bash"]), (["stof", "he"], ["health"]), (["stof", "config", "front", "pr"], ["preset"]),
                 (["stof", "config", "front", "preset", ""], ["indoor", "outdoor", "near", "fast", "quality"]),
                 (["stof", "fault", "socket", "p"], ["pmd:"]), (["stof", "fault", "socket", "pmd", ":", "v"], ["vanish"]),
                 (["stof", "fault", "socket", "pmd", ":"], "none drop delay repeat tear corrupt vanish freeze dark hang".split())]
        for name, text in self.helps.items():
            flags = re.findall(r"(?m)^  (?:-\w,)?(--[\w-]+)", text)
            asked.append((["stof", *name.split(), "--"], sorted(set(flags))))
        self.assertRegex(self.helps["config"], r"preset\s+NAME\s+\(indoor\s+outdoor\s+near\s+fast\s+quality\)")
        lines = [script]
        for words, _ in asked:
            quoted = " ".join(f"'{word}'" for word in words)
            lines.append(f"COMP_WORDS=({quoted}); COMP_CWORD={len(words) - 1}; _stof; echo \"${{COMPREPLY[*]}}\"")
        ended = subprocess.run(["bash", "--norc", "-c", "\n".join(lines)], capture_output=True, text=True, timeout=120, check=False)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        for (words, expected), line in zip(asked, ended.stdout.split("\n")):
            with self.subTest(words):
                self.assertEqual(sorted(line.split()), sorted(expected))


@unittest.skipUnless(STOFD, "no stofd in this build")
class Sensors(Program):
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
                self.assertEqual(json.loads(ended.stdout)["exported"], 4)
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
        check = subprocess.Popen([*COMMAND, "check", place, "--seconds", "6", "--timeout", "10", "--json"], cwd=self.folder, stdout=subprocess.PIPE,
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
        watch = subprocess.Popen([*COMMAND, "health", place, "--seconds", "600", "--timeout", "120"], cwd=self.folder,
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        measure = subprocess.Popen([*COMMAND, "stats", place, "--seconds", "600", "--timeout", "15"], cwd=self.folder,
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
    split = sys.argv.index("--")
    COMMAND.extend(sys.argv[split + 1:])
    part = sys.argv[1]
    OWN_NETWORK = part == "Sensors" and enter_own_network()
    result = unittest.main(argv=[sys.argv[0], part], exit=False, verbosity=2).result
    sys.exit(0 if result.wasSuccessful() else 1)


if __name__ == "__main__":
    main()
