#!/usr/bin/env python3
"""words_program_test.py -- COMMAND...: what each command of `stof` (COMMAND, with an emulator before it in a cross build) says without a
sensor: help with an example, unknown flags, mistyped words, output that cannot be written, completion."""

import json
import re
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import unittest

import verbs
from verbs import TALKERS, VERBS

ENOUGH_S = 120


class Words(verbs.Program):
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


if __name__ == "__main__":
    verbs.COMMAND.extend(sys.argv[sys.argv.index("--") + 1:])
    unittest.main(argv=sys.argv[:1], verbosity=2)
