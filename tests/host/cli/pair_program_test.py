#!/usr/bin/env python3
"""pair_program_test.py COMMAND...: `stof pair` and `stof unpair` (COMMAND: stof, with an emulator before it in a cross
build) as a user would run them, against `stofd`: STOFD holds that command, its words separated by |."""

import json
import os
import pathlib
import pty
import re
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import tty
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "host/python"))
import stof_wire as wire  # noqa: E402

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
ENOUGH_S = 60
ANSWER_S = 20  # of what is answered
CODE = "00112233445566778899aabbccddeeff"


class Proxy:
    """Between a client and the sensor: drops the answers to a step, or says that it is sensor 9 and that all went well."""

    def __init__(self, sensor, drops=None, lie=False):
        self.sensor = (sensor.split(":")[0], int(sensor.split(":")[1]))
        self.drops, self.lie, self.dropped, self.ended = drops, lie, 0, False
        self.here = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.here.bind(("127.0.0.1", 0))
        self.there = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.address = "127.0.0.1:%d" % self.here.getsockname()[1]
        self.thread = threading.Thread(target=self.serve)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.ended = True
        self.thread.join()
        self.here.close()
        self.there.close()

    def serve(self):
        client = step = None
        while not self.ended:
            for ready in select.select([self.here, self.there], [], [], 0.05)[0]:
                packet, sender = ready.recvfrom(2048)
                if ready is self.here:
                    client = sender
                    header, payload = wire.parse(packet)
                    step = payload[4] if header.type == wire.PacketType.PAIR_REQUEST else None
                    self.there.sendto(packet, self.sensor)
                elif self.drops is not None and step == self.drops:
                    self.dropped += 1
                else:
                    self.here.sendto(lied(packet) if self.lie else packet, client)


class Line:
    """A cable: two serial lines, whatever comes out of one goes into the other."""

    def __init__(self):
        self.ends = [pty.openpty() for _ in range(2)]
        self.names = [os.ttyname(tty_end) for _, tty_end in self.ends]
        for _, tty_end in self.ends:
            tty.setraw(tty_end)
        self.ended = False
        self.thread = threading.Thread(target=self.carry)
        self.thread.start()

    def carry(self):
        here, there = (far for far, _ in self.ends)
        for far in (here, there):
            os.set_blocking(far, False)
        while not self.ended:
            for ready in select.select([here, there], [], [], 0.05)[0]:
                try:
                    os.write(there if ready == here else here, os.read(ready, 4096))
                except OSError:
                    pass  # nobody reads there now: as on a cable, it is lost

    def close(self):
        self.ended = True
        self.thread.join()
        for far, tty_end in self.ends:
            os.close(far)
            os.close(tty_end)


def lied(packet):
    header, payload = wire.parse(packet)
    if header.type == wire.PacketType.SETTINGS_ANSWER and payload[4] != wire.SettingsResult.COOKIE:
        payload = payload[:4] + bytes([wire.SettingsResult.OK]) + payload[5:]
    changed = bytearray(packet)
    changed[8:12] = (9).to_bytes(4, "little")
    changed[-4 - len(payload):-4] = payload
    changed[-4:] = wire.crc32c(bytes(changed[:-4])).to_bytes(4, "little")
    return bytes(changed)


class Pair(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.environment = {**os.environ, "XDG_CONFIG_HOME": str(self.folder / "config")}
        self.own = self.folder / "config/stof/keys"
        self.keys = self.folder / "settings.json.keys"
        self.label = self.folder / "label"
        self.label.write_text(CODE[:16] + "-" + CODE[16:] + "\n", encoding="utf-8")
        self.sensor = None
        self.addCleanup(self.stop)

    def stop(self):
        if self.sensor is not None:
            self.sensor.kill()
            self.sensor.wait()
            self.sensor = None

    def until(self, what, done):
        end = time.monotonic() + ENOUGH_S
        while not (found := done()):
            self.assertIsNone(self.sensor.poll(), self.said())
            self.assertLess(time.monotonic(), end, f"{what}: {self.said()}")
            time.sleep(0.02)
        return found

    def start(self, *arguments):
        port = self.folder / "port"
        port.unlink(missing_ok=True)
        self.log = self.folder / "log"
        with self.log.open("w", encoding="utf-8") as log:
            self.sensor = subprocess.Popen(
                [*STOFD, "--size", "64x48", "--pmd", "32x24", "--port", "0", "--port-file", str(port), "--settings",
                 str(self.folder / "settings.json"), "--set", "discovery.mdns=false", "--set", "discovery.beacon=false", *arguments],
                stdout=log, stderr=subprocess.STDOUT)
        self.until("no port", lambda: port.exists() and port.read_text(encoding="utf-8").endswith("\n"))
        self.address = f"127.0.0.1:{port.read_text(encoding='utf-8').strip()}"

    def said(self):
        return self.log.read_text(encoding="utf-8")

    def press(self):
        self.until("no frame", lambda: "publishing" in self.said())
        time.sleep(0.2)  # a button that is held down at the start says nothing
        before = self.said().count("pairing is open")
        pressed, ended = 0.0, self.said().count("Press it again")

        def opened():
            nonlocal pressed, ended
            if self.said().count("pairing is open") > before:
                return True
            # A press of 0.3 s is nothing to who does not look meanwhile, and one that ends an attempt opens nothing.
            if time.monotonic() - pressed > 5 or self.said().count("Press it again") > ended:
                ended = self.said().count("Press it again")
                self.sensor.send_signal(signal.SIGUSR1)
                pressed = time.monotonic()
            return False

        self.until("no window", opened)

    def digits(self):
        return self.until("no digits", lambda: re.search(r"the digits are (\d{3} \d{3}),", self.said()))[1]

    def run_stof(self, *words, timeout_s=ANSWER_S):
        return subprocess.run([*COMMAND, *map(str, words), "--timeout", str(timeout_s)], capture_output=True, text=True, timeout=120,
                              cwd=self.folder, env=self.environment)

    def ask(self, *words, timeout_s=ANSWER_S):
        ended = self.run_stof(*words, timeout_s=timeout_s)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""), ended.stdout)
        return ended.stdout

    def refuse(self, code, fact, *words, timeout_s=ANSWER_S):
        # What views waits for frames as long as it was told to.
        ended = self.run_stof(*words, timeout_s=5 if words[0] == "view" else timeout_s)
        self.assertEqual(ended.returncode, code, ended.stdout + ended.stderr)
        self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
        self.assertIn(fact, ended.stderr)

    def begin(self, *words):
        return subprocess.Popen([*COMMAND, "pair", self.address, *words, "--timeout", str(ANSWER_S)], stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment)

    def listed(self, *words):
        return json.loads(self.ask("unpair", self.address, "--list", "--json", *words))

    def test_with_the_button_and_the_digits(self):
        self.start()
        self.refuse(1, "does not pair now: press its button", "pair", self.address)
        self.press()
        pairing = self.begin("--name", "ann@robot")
        pairing.stdin.write(self.digits() + "\n")
        pairing.stdin.flush()
        self.assertIsNone(pairing.poll())
        self.sensor.send_signal(signal.SIGUSR2)
        out, error = pairing.communicate(timeout=ENOUGH_S)
        self.assertEqual((pairing.returncode, error), (0, ""), out)
        self.assertEqual([(key["role"], key["name"]) for key in self.listed()], [("admin", "ann@robot")])
        self.assertEqual(self.keys.stat().st_mode & 0o777, 0o600)
        self.assertEqual(self.own.stat().st_mode & 0o777, 0o600)
        self.ask("config", self.address, "set", "period_ms=80")
        self.stop()
        self.start()  # the key outlives the sensor
        self.ask("config", self.address, "set", "period_ms=90")

    def start_with_line(self, *arguments):
        line = Line()
        self.addCleanup(line.close)
        self.start("--serial", line.names[0], "--baud", "921600", "--set", "serial.mode=stof", *arguments)
        self.until("no frame", lambda: "publishing" in self.said())
        return line.names[1]

    def open_window(self, line):
        window = subprocess.Popen([*COMMAND, "pair", "--serial", line, "--window", "--timeout", str(ANSWER_S)], stdin=subprocess.PIPE,
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=self.environment)
        self.addCleanup(window.kill)
        self.until("no window", lambda: "pairing is open" in self.said())
        return window

    def test_with_the_cable_in_the_buttons_place(self):
        line = self.start_with_line()
        window = self.open_window(line)
        pairing = self.begin("--name", "ann@robot", "--role", "tune")
        digits = self.digits()
        pairing.stdin.write(digits + "\n")
        pairing.stdin.flush()
        time.sleep(0.5)
        self.assertFalse(self.keys.exists())  # nobody has accepted them at the sensor
        out, error = window.communicate(digits + "\n", timeout=ENOUGH_S)
        self.assertEqual((window.returncode, error), (0, ""), out)
        asked = "role tune, asked for by 127.0.0.1"
        self.assertIn(f"the digits are {digits}, {asked}. Type them", self.said())
        self.assertIn(f"digits are {digits.replace(' ', '')}, {asked}: type them into stof pair", out)
        made = re.search(r"key ([0-9a-f]{8}) is in force", out)[1]
        out, error = pairing.communicate(timeout=ENOUGH_S)
        self.assertEqual((pairing.returncode, error), (0, ""), out)
        self.assertIn(f"key {made} of sensor 00000001, tune", out)
        self.ask("config", self.address, "set", "period_ms=80")

    def test_whoever_holds_the_cable_and_sees_other_digits_ends_it(self):
        line = self.start_with_line()
        window = self.open_window(line)
        pairing = self.begin()
        digits = self.digits()
        _, error = window.communicate("000 00\n", timeout=ENOUGH_S)
        self.assertEqual(window.returncode, 1)
        self.assertIn("nothing was paired", error)
        _, error = pairing.communicate(digits + "\n", timeout=ENOUGH_S)
        self.assertEqual(pairing.returncode, 1)
        self.assertIn("nothing was paired", error)
        self.assertFalse(self.keys.exists())

    def test_a_way_for_strangers_opens_nothing(self):
        line = self.start_with_line("--set", "serial.remote=true")
        self.refuse(1, "serial.remote", "pair", "--serial", line, "--window", timeout_s=0.3)
        self.refuse(2, "--window takes --serial", "pair", self.address, "--window")
        self.assertNotIn("pairing is open", self.said())

    def test_other_digits_pair_nobody(self):
        self.start()
        self.press()
        pairing = self.begin()
        digits = self.digits()
        pairing.stdin.write(f"{(int(digits.replace(' ', '')) + 1) % 1000000:06d}\n")
        out, error = pairing.communicate(timeout=ENOUGH_S)
        self.assertEqual(pairing.returncode, 1, out)
        self.assertIn("somebody is between you", error)
        self.sensor.send_signal(signal.SIGUSR2)
        self.refuse(1, "takes a key", "config", self.address, "set", "period_ms=80")
        self.assertFalse(self.keys.exists())

    def test_a_name_that_would_be_cut_or_changed_is_refused(self):
        self.start("--label", self.label)
        for name in ("n" * 33, "a b", "\x1b[31m"):
            self.refuse(2, "--name: takes 1 to 32 letters", "pair", self.address, "--code", CODE, "--name", name)
        self.assertFalse(self.keys.exists())

    def test_no_digits_are_no_middleman(self):
        self.start()
        self.press()
        pairing = self.begin()
        self.digits()
        out, error = pairing.communicate("", timeout=ENOUGH_S)
        self.assertEqual(pairing.returncode, 2, out)
        self.assertIn("no digits were given", error)
        self.assertFalse(self.keys.exists())

    def test_two_at_a_time_both_end(self):
        self.start()
        self.press()
        first = self.begin()
        digits = self.digits()
        self.refuse(1, "both have ended: press its button until", "pair", self.address, "--digits", "000000")
        self.until("not ended", lambda: "pairing has ended" in self.said())
        self.sensor.send_signal(signal.SIGUSR2)
        _, error = first.communicate(digits + "\n", timeout=ENOUGH_S)
        self.assertEqual(first.returncode, 1)
        self.assertIn("nothing was paired", error)
        self.assertFalse(self.keys.exists())

    def test_with_the_code_of_the_label(self):
        self.start("--label", self.label)
        self.assertIn("of sensor 00000001, tune", self.ask("pair", self.address, "--code", CODE, "--role", "tune"))
        self.ask("config", self.address, "set", "period_ms=80")
        self.refuse(1, "keys: take a key with role admin", "unpair", self.address, "--list")
        self.refuse(1, "has another code", "pair", self.address, "--code", CODE[:-1] + "e")
        self.refuse(2, "32 hexadecimal digits", "pair", self.address, "--code", CODE[:-1])

    def test_without_a_code_there_is_none(self):
        self.start()
        self.refuse(1, "has no code", "pair", self.address, "--code", CODE)

    def test_a_key_gets_a_new_secret(self):
        self.start("--label", self.label)
        self.ask("pair", self.address, "--code", CODE)
        old = self.own.read_text(encoding="utf-8")
        self.ask("pair", self.address, "--renew")
        self.assertNotEqual(self.own.read_text(encoding="utf-8"), old)
        self.ask("config", self.address, "set", "period_ms=80")
        self.assertEqual(len(self.listed()), 1)
        self.own.write_text(old, encoding="utf-8")
        self.refuse(1, "has none of your keys", "config", self.address, "set", "period_ms=90")
        self.refuse(1, "nothing was paired", "pair", self.address, "--renew")

    def test_a_key_gets_a_new_secret_over_the_cable(self):
        line = self.start_with_line("--label", self.label)
        self.ask("pair", self.address, "--code", CODE)
        old = self.own.read_text(encoding="utf-8")
        self.ask("pair", "--serial", line, "--renew")
        new = self.own.read_text(encoding="utf-8")
        self.assertNotEqual(new, old)
        self.own.write_text(old, encoding="utf-8")
        self.refuse(1, "has none of your keys", "config", self.address, "set", "period_ms=90")
        self.own.write_text(new, encoding="utf-8")
        self.ask("config", self.address, "set", "period_ms=80")

    def test_who_gives_up_leaves_nothing_open(self):
        self.start()
        for stage in ("before the digits", "after them"):
            self.press()
            pairing = self.begin()
            digits = self.digits()
            if stage == "after them":
                pairing.stdin.write(digits + "\n")
                pairing.stdin.flush()
                time.sleep(0.5)
            pairing.send_signal(signal.SIGINT)
            _, error = pairing.communicate(timeout=ENOUGH_S)
            self.assertEqual(pairing.returncode, 1, stage)
            self.assertIn("given up", error)
            self.until("still open", lambda: "ended without a key" in self.said())
            self.sensor.send_signal(signal.SIGUSR2)  # a hold for nobody
            time.sleep(4)
            self.assertFalse(self.keys.exists(), stage)
            self.stop()
            self.start()

    def test_who_gives_up_the_cables_window_closes_it(self):
        window = self.open_window(self.start_with_line())
        window.send_signal(signal.SIGINT)
        _, error = window.communicate(timeout=ENOUGH_S)
        self.assertEqual(window.returncode, 1)
        self.assertIn("given up", error)
        self.refuse(1, "does not pair now", "pair", self.address)

    def test_the_code_may_come_from_a_file_or_from_standard_input(self):
        self.start("--label", self.label)
        self.ask("pair", self.address, "--code", f"@{self.label}")
        ended = subprocess.run([*COMMAND, "pair", self.address, "--code", "-", "--timeout", str(ANSWER_S)], input=CODE + "\n",
                               capture_output=True, text=True, timeout=120, env=self.environment)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        self.assertIn("an older key", ended.stdout)
        self.refuse(2, "cannot be read", "pair", self.address, "--code", "@none")

    def test_a_renewal_whose_last_answers_are_lost(self):
        self.start("--label", self.label)
        self.ask("pair", self.address, "--code", CODE)
        with Proxy(self.address, drops=wire.PairStep.CONFIRM) as proxy:
            self.run_stof("pair", proxy.address, "--renew", timeout_s=2)  # three times as long
            self.assertGreater(proxy.dropped, 0)
        self.ask("config", self.address, "set", "period_ms=80")
        self.ask("pair", self.address, "--renew")
        self.ask("config", self.address, "set", "period_ms=90")
        self.assertEqual(len(self.listed()), 1)

    def test_whoever_says_that_he_is_another_sensor_ends_no_key(self):
        self.start("--label", self.label)
        self.ask("pair", self.address, "--code", CODE)
        own = self.own.read_text(encoding="utf-8")
        with Proxy(self.address, lie=True) as proxy:
            for words in (("unpair", proxy.address), ("unpair", proxy.address, "--id", "00000001"),
                          ("config", proxy.address, "set", "period_ms=80"), ("config", proxy.address, "save")):
                self.refuse(1, "number 9, of which you have no key", *words)
        self.assertEqual(self.own.read_text(encoding="utf-8"), own)
        self.assertEqual(len(self.listed()), 1)

    def test_a_key_whose_last_answers_are_lost(self):
        self.start("--label", self.label)
        with Proxy(self.address, drops=wire.PairStep.CONFIRM) as proxy:
            self.assertIn("is in ", self.ask("pair", proxy.address, "--code", CODE, timeout_s=2))  # three times as long
            self.assertGreater(proxy.dropped, 0)
        self.ask("config", self.address, "set", "period_ms=80")
        self.assertEqual(len(self.listed()), 1)

    def test_two_sensors_that_are_exchanged(self):
        other = Pair()
        other.setUp()
        self.addCleanup(other.doCleanups)
        for sensor, number in ((self, "1"), (other, "2")):
            sensor.start("--label", sensor.label, "--device", number)
            self.ask("pair", sensor.address, "--code", CODE)
        self.assertIn("revision 2 of sensor 1,", self.ask("config", self.address, "set", "period_ms=80"))
        self.assertIn("frames of sensor 2, signed", self.ask("view", other.address, "--signed", "--frames", 3))
        # Somebody leads the one address to the other sensor, which signs as well.
        with Proxy(other.address) as proxy:
            known = self.own.with_name("keys.sensors")
            places = known.read_text(encoding="utf-8")
            known.write_text(places.replace(self.address, proxy.address), encoding="utf-8")
            for words in (("config", proxy.address, "set", "period_ms=90"), ("unpair", proxy.address),
                          ("view", proxy.address, "--signed", "--frames", 3), ("config", proxy.address, "get", "name")):
                self.refuse(1, "number 2, but you named 1, or proved it at this address", *words)
            known.write_text(places, encoding="utf-8")
            # Nor is anything believed where none was proven, until one is named; from then on it is known.
            self.ask("config", proxy.address, "get", "name")  # which proves nothing of this place
            self.refuse(2, "several sensors (1, 2)", "config", proxy.address, "set", "period_ms=90")
            for words in (("unpair", proxy.address), ("view", proxy.address, "--signed", "--frames", 3)):
                self.refuse(2, "several sensors (1, 2)", *words)
            self.assertIn("of sensor 2,", self.ask("config", proxy.address, "set", "period_ms=90", "--device", 2))
            self.ask("config", proxy.address, "set", "period_ms=80")
            self.assertIn("of sensor 00000002", self.ask("unpair", proxy.address))
        self.assertEqual(len(self.listed()), 1)

    def test_a_sensor_that_says_the_number_of_another(self):
        other = Pair()
        other.setUp()
        self.addCleanup(other.doCleanups)
        keys = []
        for sensor in (self, other):
            sensor.start("--label", sensor.label)
            words = ("pair", sensor.address, "--code", CODE)
            if keys:
                self.refuse(1, f"number 1, which your key {keys[0]} is of already", *words)
                self.assertFalse(other.keys.exists(), "and it has no key")
                other.stop()  # and with it the attempt of before
                other.start("--label", other.label)
                words = ("pair", other.address, "--code", CODE, "--again")
            keys.append(re.match(r"key ([0-9a-f]{8}) of sensor 00000001", self.ask(*words))[1])
        self.ask("pair", self.address, "--code", CODE)  # where it was proven once more may be paired
        with Proxy(other.address) as proxy:
            for words in (("config", proxy.address, "set", "period_ms=90"), ("config", proxy.address, "set", "period_ms=90", "--device", "1")):
                self.refuse(2, "several sensors with number 1", *words)
            self.refuse(2, "several sensors with number 1", "view", proxy.address, "--signed", "--device", "1", "--frames", 3)
            self.refuse(1, "has none of your keys", "config", proxy.address, "set", "period_ms=90", "--key", keys[0])
            self.refuse(1, "no key of yours", "view", proxy.address, "--signed", "--frames", 3, "--key", keys[0])
            self.assertIn("of sensor 1,", self.ask("config", proxy.address, "set", "period_ms=90", "--key", keys[1]))
            self.ask("view", proxy.address, "--signed", "--frames", 3, "--key", keys[1])
            self.ask("pair", proxy.address, "--renew", "--key", keys[1])
            self.ask("unpair", proxy.address, "--key", keys[1])
        self.refuse(2, "8 hexadecimal digits", "config", self.address, "get", "--key", "7")
        self.refuse(2, "has no key 00000007", "config", self.address, "get", "--key", "00000007")

    def test_a_sensor_takes_sixteen_keys(self):
        for number in range(16):
            self.ask("pair", "--into", self.keys, "--keys", self.folder / f"user{number}", "--name", f"{number:x<32}")
        self.refuse(1, "keeps 16 keys", "pair", "--into", self.keys)
        self.start()
        self.ask("config", self.address, "set", "period_ms=80", "--keys", self.folder / "user15")
        self.assertEqual([key["name"] for key in self.listed("--keys", self.folder / "user15")],
                         [f"{number:x<32}" for number in range(16)])  # more than one answer holds

    def test_unpairing(self):
        self.start("--label", self.label)
        self.ask("pair", self.address, "--code", CODE)
        ann = self.folder / "ann"
        self.ask("pair", self.address, "--code", CODE, "--role", "view", "--name", "ann", "--keys", ann)
        bob = self.folder / "bob"
        self.ask("pair", self.address, "--code", CODE, "--role", "tune", "--name", "bob", "--keys", bob)
        keys = {key["name"]: key["id"] for key in self.listed()}
        rows = [line.split() for line in self.ask("unpair", self.address, "--list").splitlines()]
        self.assertEqual(rows[0], ["key", "role", "yours", "name"])
        self.assertEqual([row[:2] for row in rows[1:]], [[key["id"], key["role"]] for key in self.listed()])
        self.assertEqual(["yes" in row for row in rows[1:]], [True, False, False])
        self.refuse(1, "takes a key with role admin", "unpair", self.address, "--id", keys["bob"], "--keys", ann)
        self.ask("unpair", self.address, "--keys", ann)  # her own
        self.ask("unpair", self.address, "--id", keys["bob"])
        self.refuse(2, "there is no key", "unpair", self.address, "--id", keys["bob"])
        self.refuse(1, "has none of your keys", "unpair", self.address, "--id", keys["bob"], "--keys", bob)
        self.refuse(1, "has none of your keys", "config", self.address, "set", "period_ms=90", "--keys", bob)
        self.assertEqual(len(self.listed()), 1)
        self.ask("unpair", self.address)
        self.ask("config", self.address, "set", "depth.max_range_mm=5000")  # unpaired
        self.refuse(1, "takes a key", "config", self.address, "set", "period_ms=90")
        self.refuse(2, "nothing was forgotten", "unpair", "--forget", "--device", "1", "--id", "0000000b", "--keys", bob)
        self.assertIn("1 keys of sensor", self.ask("unpair", "--forget", "--device", "1", "--keys", bob))
        self.refuse(2, "nothing was forgotten", "unpair", "--forget", "--device", "1", "--keys", bob)

    def test_bad_command_lines(self):
        self.refuse(2, "give a sensor", "pair")
        self.refuse(2, "give a sensor", "unpair", "127.0.0.1:1", "--serial", "/dev/null", "--id", "00000001")
        self.refuse(2, "--role", "pair", "127.0.0.1:1", "--role", "king")
        # Nobody is asked: a key that the user has not, words that are no id, and what goes not together.
        self.refuse(2, "has no key of this sensor", "unpair", "127.0.0.1:1")
        self.refuse(2, "has no key of this sensor", "pair", "127.0.0.1:1", "--renew")
        self.refuse(2, "has no key 00000007", "unpair", "127.0.0.1:1", "--key", "00000007")
        self.refuse(2, "--id: takes the 8 hexadecimal digits", "unpair", "127.0.0.1:1", "--id", "7")
        self.refuse(2, "excludes", "unpair", "127.0.0.1:1", "--list", "--forget")
        self.refuse(2, "stof pair 127.0.0.1:1", "unpair", "127.0.0.1:1", "--list")
        self.ask("pair", "--into", self.keys)
        self.refuse(1, "no answer", "unpair", "127.0.0.1:1", "--list", timeout_s=0.05)
        self.refuse(1, "no answer", "pair", "127.0.0.1:1", timeout_s=0.05)
        ended = subprocess.run([*STOFD, "--label", self.folder / "none"], capture_output=True, text=True, timeout=60)
        self.assertEqual(ended.returncode, 2)
        self.assertIn("32 hexadecimal digits", ended.stderr)


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=sys.argv[:1])
