#!/usr/bin/env python3
"""view_panels_test.py COMMAND...: what a page of `stof view` (COMMAND: stof) has done that outlives it: a key that is made, a release
that is put on the sensor; with a WebSocket client in place of a browser. STOFD holds that command, its words separated by |.
STOF_LONG=1: also what takes half a minute."""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

from view_programs import COMMAND, ENOUGH_S, STOFD, Program, Sensor, View, await_
from web_client import WebSocket

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from udp_ports import lasting_port  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]
LONG = os.environ.get("STOF_LONG") == "1"
CODE = "00112233445566778899aabbccddeeff"


class Panels(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.keys_of("config")

    def keys_of(self, name):
        """Whose keys the programs that are started from now on have; the file."""
        environment = unittest.mock.patch.dict(os.environ, {"XDG_CONFIG_HOME": str(self.folder / name)})
        environment.start()
        self.addCleanup(environment.stop)
        return self.folder / name / "stof/keys"

    def start(self, kind, *arguments, **named):
        program = kind(self.folder, *arguments, **named)
        self.addCleanup(program.stop)
        return program

    def page(self, view, token=None):
        page = WebSocket(view.port, token=token)
        self.addCleanup(page.close)
        return page

    def until_done(self, page, what, **members):
        """A busy machine's program may not have heard of the sensor yet."""
        end = time.monotonic() + ENOUGH_S
        while not (answer := page.wish(what, **members))["done"]:
            self.assertLess(time.monotonic(), end, answer)
            time.sleep(0.2)
        return answer


class Pairing(Panels):
    def sensor(self):
        label = self.folder / "label"
        label.write_text(CODE + "\n", encoding="utf-8")
        label.chmod(0o600)
        sensor = self.start(Sensor, "--settings", self.folder / "settings.json", "--label", label)
        await_("a frame", lambda: "publishing" in sensor.text())
        time.sleep(0.2)  # a button that is held down at the start says nothing
        return sensor

    def press(self, sensor):
        before = sensor.text().count("pairing is open")
        ended = sensor.text().count("Press it again")
        sensor.process.send_signal(signal.SIGUSR1)
        await_("an answer to the press", lambda: sensor.text().count("pairing is open") > before or sensor.text().count("Press it again") > ended)
        if sensor.text().count("pairing is open") == before:  # an attempt was under way: it has ended
            sensor.process.send_signal(signal.SIGUSR1)
            await_("a window", lambda: sensor.text().count("pairing is open") > before)

    def begin(self, page, step, code="", role="admin"):
        """The state once it is that one."""
        self.until_done(page, "pair", code=code, role=role)
        state = page.until("pairing", lambda told: told["step"] in (step, "failed", "paired"))
        self.assertEqual(state["step"], step, state)
        return state

    def digits(self, sensor, number):
        """Of that attempt, as the sensor tells them."""
        await_("digits", lambda: len(re.findall(r"the digits are (\d{3} \d{3}),", sensor.text())) >= number)
        return re.findall(r"the digits are (\d{3} \d{3}),", sensor.text())[number - 1]

    def test_a_page_pairs_by_button_and_digits_and_sees_no_key(self):
        sensor = self.sensor()
        view = self.start(View, sensor, "--http-port", "0")
        keys = self.keys_of("config")
        with WebSocket(view.port) as page:
            self.assertEqual(page.until("pairing", lambda told: told["offer"] != "")["offer"], "unpaired")
            self.assertFalse(page.wish("digits", digits="123456")["done"])
            self.assertFalse(page.wish("end_pairing")["done"])
            # In the sensor's words.
            self.assertIn("does not pair now: press its button", self.begin(page, "failed")["text"])
            self.press(sensor)
            # Those of here are told once somebody has given those of the sensor.
            self.assertEqual(self.begin(page, "digits")["ours"], "")
            self.assertFalse(page.wish("pair", code="", role="admin")["done"])  # one is under way
            # Another page sees who asks for what, and is refused in one line.
            with WebSocket(view.port) as other:
                state = other.until("pairing", lambda told: told["step"] == "digits")
                self.assertEqual((state["role"], state["by"]["place"]), ("admin", "this computer"))
                self.assertEqual(state["by"]["page"], page.told["rights"]["page"])
                self.assertNotEqual(state["by"]["page"], other.until("rights")["page"])
                for what, members in (("digits", {"digits": self.digits(sensor, 1)}), ("end_pairing", {})):
                    answer = other.wish(what, **members)
                    self.assertEqual((answer["done"], answer["text"]),
                                     (False, "another page, of this computer, began this: only that page goes on with it or ends it"))
                self.assertIn("a pairing is under way", other.wish("pair", code="", role="view")["text"])
                self.assertEqual((other.told["pairing"]["step"], other.told["pairing"]["given"]), ("digits", ""))
            for wrong in ("12345", "1234567", ""):
                self.assertFalse(page.wish("digits", digits=wrong)["done"])
            true = self.digits(sensor, 1).replace(" ", "")
            other = f"{(int(true) + 1) % 1_000_000:06}"
            self.assertTrue(page.wish("digits", digits=other)["done"])
            state = page.until("pairing", lambda told: told["step"] == "failed")
            self.assertIn(f"{other} was given, the digits here are {true}", state["text"])
            self.assertFalse((self.folder / "settings.json.keys").exists())
            # Given up.
            self.press(sensor)
            self.begin(page, "digits")
            self.digits(sensor, 2)  # it tells them with its next frame: not where they are given up before
            self.assertTrue(page.wish("end_pairing")["done"])
            self.assertIn("given up", page.until("pairing", lambda told: told["step"] == "failed")["text"])
            # Its page is closed.
            self.press(sensor)
            with WebSocket(view.port) as other:
                self.begin(other, "digits", role="tune")
                self.digits(sensor, 3)
            state = page.until("pairing", lambda told: told["step"] == "failed" and told["role"] == "tune")
            self.assertEqual(state["text"], "the page that began the pairing was closed: nothing was paired")
            # And well.
            self.press(sensor)
            self.begin(page, "digits")
            self.digits(sensor, 4)
            self.assertIn("role admin, asked for by 127.0.0.1. Type them", sensor.text())
            self.assertTrue(page.wish("digits", digits=self.digits(sensor, 4))["done"])
            state = page.until("pairing", lambda told: told["step"] == "accept")
            self.assertEqual(state["given"], state["ours"])
            sensor.process.send_signal(signal.SIGUSR2)
            state = page.until("pairing", lambda told: told["step"] == "paired")
            self.assertRegex(state["text"], r"^key [0-9a-f]{8} of sensor 00000001, admin, is in ")
            self.assertEqual(state["offer"], "")  # a page that is opened now offers nothing that is done
            self.assertEqual(keys.stat().st_mode & 0o777, 0o600)
            secrets = re.findall(r"[0-9a-f]{32,}", keys.read_text(encoding="utf-8"))
            self.assertTrue(secrets)
            self.assertFalse([secret for secret in secrets if secret in str(page.told)])
            # It counts at once.
            self.until_done(page, "set", settings={"depth.preset": "fast"})
            page.until("pairing", lambda told: told["offer"] == "")

    def test_a_page_pairs_by_the_code_but_not_over_the_network(self):
        sensor = self.sensor()
        self.keys_of("other")
        paired = subprocess.run([*COMMAND, "pair", f"127.0.0.1:{sensor.port}", "--code", CODE, "--timeout", "10"], capture_output=True,
                                text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(paired.returncode, 0, paired.stderr)
        self.keys_of("config")
        lan = self.start(View, sensor, "--http-port", "0", "--lan", "--lan-control", name="lan")
        token = re.search(r"\?token=([0-9a-f]{32})$", lan.addresses[0])[1]
        with WebSocket(lan.port, token=token) as page:
            self.assertEqual(page.until("rights")["why_not_pair"], "")  # it is of this machine
            page.until("status", lambda told: told["frames"] > 0)  # without any it would end with 1
        if len(lan.addresses) > 1:  # this machine has a network
            address = re.match(r"http://([0-9.]+):", lan.addresses[1])[1]
            with WebSocket(lan.port, token=token, address=address) as page:
                self.assertTrue(page.until("rights")["may"])
                for what, members in (("pair", {"code": "", "role": "admin"}), ("pair", {"code": CODE, "role": "admin"}),
                                      ("digits", {"digits": "123456"}), ("end_pairing", {})):
                    answer = page.wish(what, **members)
                    self.assertFalse(answer["done"])
                    self.assertIn("only a page on the machine of stof view pairs", answer["text"])
                self.assertEqual(page.until("pairing")["step"], "none")
        self.assertEqual(lan.stop(), 0)
        view = self.start(View, sensor, "--http-port", "0")
        with WebSocket(view.port) as page:
            self.assertEqual(page.until("pairing", lambda told: told["offer"] != "")["offer"], "no_key")
            self.assertIn("32 hexadecimal digits", page.wish("pair", code=CODE[:-1], role="tune")["text"])
            state = self.begin(page, "paired", CODE, "tune")
            self.assertRegex(state["text"], r"^key [0-9a-f]{8} of sensor 00000001, tune, is in ")
            self.assertIn("has another code", self.begin(page, "failed", CODE[:-1] + "e", "tune")["text"])
            self.assertNotIn(CODE, str(page.told))
        self.assertEqual(view.stop(), 0)
        self.assertNotIn(CODE, view.text())

    def test_it_ends_at_once_while_a_page_pairs(self):
        sensor = self.sensor()
        view = self.start(View, sensor, "--http-port", "0")
        self.press(sensor)
        page = self.page(view)
        page.until("pairing", lambda told: told["offer"] != "")
        self.begin(page, "digits")
        self.assertEqual(view.stop(), 0)  # and not after the two minutes that digits are awaited


class Update(Panels):
    def emulated(self, command, *words):
        subprocess.run([ROOT / "scripts/emulated_board", command, self.folder / "card", "--stofd", STOFD[-1], *words], check=True,
                       timeout=ENOUGH_S)

    def test_a_page_puts_a_release_of_the_folder_and_tells_how_it_goes(self):
        settings = self.folder / "settings.json"
        self.emulated("make")
        subprocess.run([*COMMAND, "pair", "--into", f"{settings}.keys"], check=True, timeout=ENOUGH_S, stdout=subprocess.DEVNULL)
        releases = self.folder / "releases"
        releases.mkdir()
        crash = self.folder / "crash"
        crash.write_text("#!/bin/sh\nexit 1\n", encoding="ascii")
        self.emulated("release", releases / "crash.update", "--program", crash)
        self.emulated("release", releases / "good.update", "--version", "2.0")
        (releases / "torn.update").write_bytes(b"STOFUPD")
        (releases / "letter.txt").write_text("no release", encoding="ascii")
        (self.folder / "outside.update").write_bytes((releases / "good.update").read_bytes())

        class Board:
            port = lasting_port()

        board = Program([ROOT / "scripts/emulated_board", "run", self.folder / "card", "--stofd", STOFD[-1], "--size", "64x48", "--pmd", "32x24",
                         "--port", Board.port, "--settings", settings, "--set", "discovery.mdns=false", "--set", "discovery.beacon=false"],
                        self.folder, "board")
        self.addCleanup(board.stop)
        await_("a frame", lambda: "publishing" in board.text())
        with WebSocket(self.start(View, Board, "--http-port", "0", "--timeout", "60", name="bare").port) as page:
            self.until_done(page, "release")
            self.assertEqual((page.until("update")["folder"], page.until("update")["files"]), ("", []))
            for wish in ({"what": "update", "file": "good.update"}, {"what": "revert"}):
                self.assertIn("--update-from", page.wish(**wish)["text"])
        view = self.start(View, Board, "--http-port", "0", "--timeout", "60", "--update-from", releases)
        page = self.page(view)
        page.until("status", lambda told: told["health"])
        end = time.monotonic() + ENOUGH_S
        while not (page.wish("release") and page.until("update")["running"]):
            self.assertLess(time.monotonic(), end, page.told["update"])
        state = page.until("update")
        self.assertEqual(([one["name"] for one in state["files"]], state["state"]), (["crash.update", "good.update", "torn.update"], "settled"))
        former = state["running"]
        for name in ("none.update", "letter.txt", "outside.update"):
            self.assertIn("choose one of the list", page.wish("update", file=name)["text"])
        self.assertTrue(page.wish("update", file="torn.update")["done"])
        self.assertIn("is no update file", page.until("update", lambda told: told["step"] == "failed")["text"])
        self.assertTrue(page.wish("update", file="crash.update")["done"])
        self.assertFalse(page.wish("update", file="good.update")["done"])  # one is under way
        state = page.until("update", lambda told: told["step"] in ("left", "failed"))
        self.assertEqual(state["step"], "left", state)
        self.assertIn("went back to the former release", state["text"])
        self.assertGreater(state["total"], 0)
        self.assertEqual(state["sent"], state["total"])
        # What is in the other slot is tried again, and left again.
        self.until_done(page, "revert")
        self.assertEqual(page.until("update", lambda told: told["step"] in ("restarting", "left"))["file"], "")
        state = page.until("update", lambda told: told["step"] in ("left", "failed"))
        self.assertEqual(state["step"], "left", state)
        self.until_done(page, "update", file="good.update")
        state = page.until("update", lambda told: told["step"] in ("trial", "left", "failed"))
        self.assertEqual(state["step"], "trial", state)
        if LONG:
            self.assertEqual(page.until("update", lambda told: told["step"] != "trial")["step"], "confirmed")
        self.assertEqual(view.stop(), 0)  # the sensor goes on without it
        # Another program's page sees what runs, whoever put it there.
        late = self.page(self.start(View, Board, "--http-port", "0", "--timeout", "60", name="late"))
        late.until("status", lambda told: told["health"])
        while not (late.wish("release") and late.until("update")["running"]):
            pass
        self.assertNotEqual(late.until("update")["running"], former)
        self.assertEqual(late.until("update")["state"], "settled" if LONG else "trial")


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=[sys.argv[0]], verbosity=2)
