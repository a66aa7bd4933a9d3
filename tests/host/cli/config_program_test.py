#!/usr/bin/env python3
"""config_program_test.py COMMAND...: `stof config` (COMMAND: stof, with an emulator before it in a cross build) as a
user would run it, against `stofd`: STOFD holds that command, its words separated by |."""

import hashlib
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "host/python"))
import stof_wire as wire  # noqa: E402

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
ENOUGH_S = 60
ANSWER_S = "20"  # of what is answered


class Config(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.file = self.folder / "settings.json"
        self.paired = True
        self.sensor = None
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(self.folder / "config")}

    def pair(self, *arguments):
        """This user has a key of the sensor that starts next."""
        return subprocess.run([*COMMAND, "pair", "--into", f"{self.file}.keys", *arguments], capture_output=True, text=True,
                              timeout=120, env=self.environment, check=True).stdout

    def tearDown(self):
        self.cut_power()

    def start(self, *arguments):
        """Starts stofd; what it has printed so far is in self.log."""
        self.assertIsNone(self.sensor)
        if self.paired:
            self.pair()
        port = self.folder / "port"
        port.unlink(missing_ok=True)
        self.log = self.folder / "log"
        with self.log.open("w", encoding="utf-8") as log:
            self.sensor = subprocess.Popen(
                [*STOFD, "--size", "64x48", "--pmd", "32x24", "--port", "0", "--port-file", str(port), "--settings", str(self.file),
                 "--set", "discovery.mdns=false", "--set", "discovery.beacon=false", *arguments], stdout=log, stderr=subprocess.STDOUT)
        end = time.monotonic() + ENOUGH_S
        while not (port.exists() and port.read_text(encoding="utf-8").endswith("\n")):
            self.assertIsNone(self.sensor.poll(), self.log.read_text(encoding="utf-8"))
            self.assertLess(time.monotonic(), end, "stofd does not start")
            time.sleep(0.02)
        self.address = f"127.0.0.1:{port.read_text(encoding='utf-8').strip()}"

    def expect_told(self, text):
        """stofd prints it, if not by now: what it says of its start may come behind the port's file."""
        end = time.monotonic() + ENOUGH_S
        while text not in self.log.read_text(encoding="utf-8"):
            self.assertIsNone(self.sensor.poll(), self.log.read_text(encoding="utf-8"))
            self.assertLess(time.monotonic(), end, self.log.read_text(encoding="utf-8"))
            time.sleep(0.02)

    def cut_power(self):
        if self.sensor is not None:
            self.sensor.kill()
            self.sensor.wait()
            self.sensor = None

    def run_config(self, *words):
        return subprocess.run([*COMMAND, "config", *map(str, words)], capture_output=True, text=True, timeout=120,
                              cwd=self.folder, env=self.environment)

    def ask(self, *words):
        ended = self.run_config(self.address, *words, "--timeout", ANSWER_S)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        return ended.stdout

    def refuse(self, code, fact, *words):
        ended = self.run_config(*words)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertTrue(ended.stderr.startswith("stof: "), ended.stderr)
        self.assertIn(fact, ended.stderr)

    def test_bad_command_lines(self):
        self.refuse(2, "which sensor", )
        self.refuse(2, "which sensor is missing before get", "get")
        self.refuse(2, "which sensor is missing before set", "set", "name=arm")
        self.refuse(2, "--device", "127.0.0.1:1", "get", "--device", "0")
        self.refuse(2, "what to do", "127.0.0.1:1")
        self.refuse(2, "erase", "127.0.0.1:1", "erase")
        self.refuse(2, "nothing to change", "127.0.0.1:1", "set")
        self.refuse(2, "absent.json", "127.0.0.1:1", "set", "absent.json")
        self.refuse(2, "--document", "127.0.0.1:1", "get", "--document", "none")
        self.refuse(2, "/dev/absent", "--serial", "/dev/absent", "get")
        self.refuse(1, "127.0.0.1:1", "127.0.0.1:1", "get", "--timeout", "0.05")

    def test_what_was_committed_outlives_a_power_cut(self):
        self.start()
        self.ask("set", "depth.max_range_mm=3000")
        self.ask("stage", "name=arm", "depth.preset=quality")
        self.assertEqual(self.ask("get", "name"), "stof\n")
        self.ask("commit")
        self.ask("set", "depth.max_range_mm=4000")
        self.cut_power()
        self.start()
        self.assertEqual(self.ask("get", "name"), "arm\n")
        self.assertEqual(self.ask("get", "depth.preset"), "quality\n")
        self.assertEqual(self.ask("get", "depth.max_range_mm"), "3000\n")
        self.assertEqual(sorted(json.loads(self.ask("diff", "--json"))),
                         ["depth.max_range_mm", "depth.preset", "discovery.beacon", "discovery.mdns", "name", "udp.port"])
        self.assertEqual(self.ask("get", "udp.port").strip(), self.address.rpartition(":")[2], "the port that is listened at")
        # What the command line alone set is in force, and not in the file.
        saved = json.loads(self.file.read_text(encoding="utf-8"))
        self.assertEqual((saved["discovery"]["mdns"], saved["udp"]["port"]), (True, 7560))

    def test_a_damaged_file_is_told_and_kept(self):
        damaged = '{"name": "arm", "period_ms": 50'
        self.file.write_text(damaged, encoding="utf-8")
        self.start()
        self.assertEqual(self.ask("get", "name"), "stof\n")
        self.expect_told(f"{self.file}: not JSON: it ends too early: the defaults hold")
        self.assertEqual(pathlib.Path(f"{self.file}.bad").read_text(encoding="utf-8"), damaged)

    def test_a_stranger_cannot_keep_the_sensor_from_starting(self):
        self.start()
        before = self.ask("get")
        self.refuse(2, "network: the addresses of this machine are its administrator's", self.address, "set", "network.dhcp=false",
                    "--timeout", ANSWER_S)
        for device in ("/dev/watchdog0", "/dev/nope", "/dev/pts/0"):
            self.refuse(2, "serial.device: takes a line of board emu", self.address, "set", f"serial.device={device}", "--timeout", ANSWER_S)
            self.refuse(2, "serial.device: takes a line of board emu", self.address, "set", "name=x", f"serial.device={device}",
                        "--timeout", ANSWER_S)
        self.assertEqual(self.ask("get"), before)
        self.ask("set", "serial.device=/dev/ttyS99", "serial.mode=stof", "depth.max_range_mm=500")
        self.ask("save")
        for start in range(4):
            self.cut_power()
            self.start()
            range_mm = self.ask("get", "depth.max_range_mm")
            self.assertEqual(range_mm, "500\n" if start < 2 else "10000\n", self.log.read_text(encoding="utf-8"))
        self.expect_told("two starts with these settings have failed")
        self.assertEqual(self.ask("get", "depth.max_range_mm", "--document", "saved"), "10000\n")
        self.ask("save")
        self.assertEqual(json.loads(self.file.read_text(encoding="utf-8"))["depth"]["max_range_mm"], 10000)

    def test_saves_have_a_limit(self):
        self.start()
        for number in range(10):
            self.ask("set", f"name=n{number}")
            self.ask("save")
        self.ask("set", "name=late")
        ended = self.run_config(self.address, "save", "--timeout", ANSWER_S)
        self.assertNotEqual(ended.returncode, 0)
        self.assertIn("then one a minute", ended.stdout + ended.stderr)
        self.assertEqual(json.loads(self.file.read_text(encoding="utf-8"))["name"], "n9")

    def test_what_the_board_cannot_do_is_refused_and_nothing_changes(self):
        self.start("--set", "name=bench")
        before = self.ask("get")
        ended = self.run_config(self.address, "set", "name=x", "depth.disparities=200", "--timeout", ANSWER_S)
        self.assertEqual(ended.returncode, 2)
        self.assertIn("200 disparities are more than the 128 of board emu", ended.stderr)
        self.assertEqual(self.ask("get"), before)
        self.assertEqual(json.loads(before)["name"], "bench")

    def test_whoever_has_no_key_reads_and_changes_what_is_harmless_until_somebody_has_one(self):
        self.paired = False
        self.start()
        self.ask("set", "depth.max_range_mm=3000", "streams.grey_left=rvl")
        for words, told in ((("set", "period_ms=60000"), "period_ms: takes a key with role tune or admin"),
                            (("set", "udp.port=68"), "udp.port: takes a key with role admin"),
                            (("set", "serial.device=/dev/ttyS9"), "serial.device: takes a key with role admin"),
                            (("set", "depth.max_range_mm=500"), "limits.least_range_mm is 1000"),
                            (("set", "streams.depth=off"), "limits.streams is keep"),
                            (("save",), "save: takes a key"), (("reset",), "takes a key"), (("preset", "near"), "takes a key"),
                            (("commit",), "commit: takes a key"), (("stage", "name=x"), "stage: takes a key")):
            self.refuse(1, told, self.address, *words, "--timeout", ANSWER_S)
        self.assertEqual(self.ask("get", "depth.max_range_mm"), "3000\n")
        self.cut_power()
        self.paired = True
        self.start()
        self.ask("set", "period_ms=50")
        self.ask("save")
        self.environment["XDG_CONFIG_HOME"] = str(self.folder / "stranger")
        self.refuse(1, "depth.max_range_mm: takes a key", self.address, "set", "depth.max_range_mm=3000", "--timeout", ANSWER_S)
        self.assertEqual(self.ask("get", "period_ms"), "50\n")

    def test_roles(self):
        self.paired = False
        self.pair("--role", "tune", "--name", "ann")
        self.start()
        self.ask("set", "depth.guided=true", "period_ms=100")
        self.ask("save")
        self.refuse(1, "discovery.beacon: takes a key with role admin", self.address, "set", "discovery.beacon=true", "--timeout", ANSWER_S)
        self.refuse(1, "limits.most_period_ms is 1000", self.address, "set", "period_ms=1001", "--timeout", ANSWER_S)

    def test_a_request_that_is_signed_as_the_document_says_is_served(self):
        self.pair("--role", "tune")
        line = pathlib.Path(f"{self.file}.keys").read_text(encoding="utf-8").splitlines()[-2]
        key_id, device, _, secret, _ = line.split()
        self.start()
        host, port = self.address.split(":")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sensor:
            sensor.settimeout(20)
            sensor.connect((host, int(port)))
            sensor.send(wire.seal(wire.Header(type=wire.PacketType.SETTINGS_REQUEST),
                                  wire.SettingsRequest(request_id=1).pack()))
            header, payload = wire.parse(sensor.recv(2000))
            request = wire.SettingsRequest(request_id=2, operation=wire.SettingsOperation.SET,
                                           cookie=wire.SettingsAnswer.unpack(payload).cookie)
            signed = wire.SignedFields(key_id=int(key_id, 16), type=132, counter=1).pack() + request.pack() + b'{"period_ms": 80}'
            packet = wire.seal(wire.Header(type=wire.PacketType.SIGNED_REQUEST, origin=header.origin), signed + bytes(16))
            tag = hashlib.blake2b(packet[:-20], digest_size=16, key=bytes.fromhex(secret)).digest()
            sensor.send(wire.seal(wire.Header(type=wire.PacketType.SIGNED_REQUEST, origin=header.origin), signed + tag))
            answer = sensor.recv(2000)
        header, payload = wire.parse(answer)
        self.assertEqual((header.type, header.origin.device_id), (wire.PacketType.SIGNED_ANSWER, int(device, 16)))
        self.assertEqual(hashlib.blake2b(answer[:-20], digest_size=16, key=bytes.fromhex(secret)).digest(), answer[-20:-4])
        fields = wire.SignedFields.unpack(payload)
        self.assertEqual((fields.key_id, fields.type, fields.counter, fields.highest), (int(key_id, 16), 133, 1, 1))
        self.assertEqual(self.ask("get", "period_ms"), "80\n")

    def test_a_key_file_is_its_owners_and_damage_is_told(self):
        self.assertIn("admin, is in", self.pair())
        self.assertIn("already", self.pair())
        keys = pathlib.Path(f"{self.file}.keys")
        own = self.folder / "config/stof/keys"
        for file in (keys, own):
            self.assertEqual(file.stat().st_mode & 0o777, 0o600)
        keys.write_text("damaged\n")
        self.paired = False
        self.start()
        self.expect_told(f"{keys}: no key file, or damaged: no client's key is known")
        self.assertEqual(keys.read_text(), "damaged\n")
        self.refuse(1, "has none of your keys", self.address, "set", "name=x", "--timeout", ANSWER_S)
        self.assertEqual(self.ask("get", "name"), "stof\n")
        own.chmod(0o644)
        self.refuse(2, "others may read these keys", self.address, "get", "--timeout", ANSWER_S)

    def test_schema_is_the_one_in_docs(self):
        self.start()
        docs = pathlib.Path(__file__).resolve().parents[3] / "docs" / "settings.schema.json"
        self.assertEqual(self.ask("schema"), docs.read_text(encoding="utf-8"))


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=sys.argv[:1])
