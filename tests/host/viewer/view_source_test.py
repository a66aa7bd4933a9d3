#!/usr/bin/env python3
"""view_source_test.py COMMAND...: what `stof view` (COMMAND: stof) shows and where it goes: a sensor that restarts, recordings, pictures
without a page. STOFD holds that program's command, its words separated by |."""

import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

from view_programs import COMMAND, ENOUGH_S, MOST_PAGES, Sensor, View, await_
from web_client import Refused, WebSocket, get

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from udp_ports import lasting_port  # noqa: E402


class Sources(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def start(self, kind, *arguments, **named):
        program = kind(self.folder, *arguments, **named)
        self.addCleanup(program.stop)
        return program

    def test_a_sensor_that_restarts_is_shown_again_and_a_token_keeps_others_out(self):
        sensor = self.start(Sensor, port=lasting_port())
        view = self.start(View, sensor, "--lan", "--http-port", "0", "--timeout", "5", "--foxglove-origin", "https://app.example")
        token = re.search(r"\?token=([0-9a-f]{32})$", view.addresses[0])[1]
        for wrong in ("", "0" * 32, token[:-1], token + "0"):
            self.assertEqual(get(view.port, f"/?token={wrong}")[0], 403)
            with self.assertRaises(Refused) as refused:
                WebSocket(view.port, token=wrong)
            self.assertEqual(refused.exception.status, 403)
        self.assertEqual(get(view.port, f"/?token={token}")[0], 200)
        self.assertEqual(get(view.port, f"/?token={token}", host="10.1.2.3:80")[0], 200)
        self.assertEqual(get(view.port, f"/?token={token}", host="evil.example")[0], 403)
        for subprotocol, given, origin, status in (("foxglove.sdk.v1", token, "https://app.example", 0),
                                                   ("foxglove.sdk.v1", "", "https://app.example", 403), ("foxglove.sdk.v1", token, "https://app.evil", 403),
                                                   ("stof.view.v1", token, "https://app.example", 403),
                                                   ("foxglove.sdk.v1, stof.view.v1", token, "https://app.example", 403)):
            try:
                WebSocket(view.port, token=given, subprotocol=subprotocol, origin=origin).close()
                self.assertEqual(status, 0)
            except Refused as refused:
                self.assertEqual(refused.status, status, (subprotocol, given, origin))
        if len(view.addresses) > 1:  # this machine has a network: a crowd from there leaves the user's own page its place
            address = re.match(r"http://([0-9.]+):", view.addresses[1])[1]
            crowd = []
            for _ in range(100):
                try:
                    crowd.append(WebSocket(view.port, token=token, address=address))
                except Refused as one:
                    self.assertIn(one.status, (503, 0))
            self.assertTrue(1 <= len(crowd) <= MOST_PAGES // 2, len(crowd))
            with WebSocket(view.port, token=token) as page:
                page.ask("depth")
                page.frame()
            for one in crowd:
                one.close()
        with WebSocket(view.port, token=token) as page:
            page.ask("depth")
            session = page.frame()[0]["session"]
            self.assertEqual(sensor.stop(), 0)
            while "silent" not in (status := page.message("status"))["link"]:
                pass
            # Longer than --timeout: nobody ends while a page is there.
            end = time.monotonic() + 6
            while time.monotonic() < end:
                status = page.message("status")
            self.assertIn("no frame comes", status["waiting"])
            self.start(Sensor, port=sensor.port, name="again")
            page.ask("depth")
            head, _ = page.frame()
            self.assertNotEqual(head["session"], session)
        with WebSocket(view.port, token=token) as later:  # what was before it is told, too
            events, end = [], time.monotonic() + 10
            while not any(event["text"].startswith("link: the sensor sends again") for event in events) and time.monotonic() < end:
                opcode, payload = later.receive()
                events += [json.loads(payload)] if opcode == 1 and json.loads(payload)["type"] == "event" else []
            for what, active in (("is silent", True), ("started again", True), ("sends again", False)):
                self.assertIn((what, active, None), [(what, event["active"], event["condition"]) for event in events
                                                     if event["text"].startswith(f"link: the sensor {what}")])
        self.assertEqual(view.stop(), 0)
        self.assertEqual(view.text().count(token), len(view.addresses))

    def test_a_recording_is_shown_again_and_again(self):
        sensor = self.start(Sensor)
        file = pathlib.Path(self.folder) / "it.mcap"
        made = subprocess.run([*COMMAND, "record", f"127.0.0.1:{sensor.port}", file, "--frames", "6", "--timeout", "20"], capture_output=True,
                              text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(sensor.stop(), 0)
        log = pathlib.Path(self.folder) / "replay.log"
        with log.open("w", encoding="utf-8") as lines:
            view = subprocess.Popen([*COMMAND, "view", file, "--http-port", "0"], stdout=lines, stderr=lines)
        self.addCleanup(view.kill)
        await_("its address", lambda: "page: " in log.read_text(encoding="utf-8"))
        with WebSocket(int(re.search(r":(\d+)/", log.read_text(encoding="utf-8"))[1])) as page:
            hello = page.message("hello")
            self.assertEqual((hello["sensor"], hello["recording"]), ("it.mcap", True))
            numbers = []
            while not any(after < before for before, after in zip(numbers, numbers[1:])):  # it began again
                page.ask("depth", "left")
                head, planes = page.frame()
                self.assertEqual(head["planes"], ["depth", "left"])
                self.assertGreater(len(set(planes["left"])), 10)
                numbers.append(head["frame"])
            self.assertEqual(page.message("status")["link"], [])
            self.assertTrue(page.wish("play", on=False)["done"])
            self.assertTrue(page.until("playback", lambda place: not place["playing"])["seekable"])
            self.assertFalse(page.wish("settings")["done"])
            self.assertFalse(page.wish("record", on=True)["done"])
            shown = []
            for to_ms in (0, 1 << 40, 0):
                self.assertTrue(page.wish("seek", to_ms=to_ms)["done"])
                page.until("playback", lambda place, to=to_ms: place["at_ms"] == min(to, place["length_ms"]))
                page.ask("depth")
                shown.append(page.frame()[0]["frame"])
            self.assertEqual(shown[0], shown[2])
            self.assertLessEqual(shown[0], min(numbers))
            self.assertGreaterEqual(shown[1], max(numbers))
            with WebSocket(page.socket.getpeername()[1]) as later:  # what halts is there for who comes later
                later.ask("depth")
                self.assertEqual(later.frame()[0]["frame"], shown[2])
        view.send_signal(signal.SIGTERM)
        self.assertEqual(view.wait(ENOUGH_S), 0)
        for flags in (["--frames", "1"], ["--headless", "x"], ["--signed"], ["--lan-control"]):
            ended = subprocess.run([*COMMAND, "view", file, *flags], capture_output=True, text=True, timeout=ENOUGH_S, check=False)
            self.assertEqual((ended.returncode, ended.stderr.count("\n")), (2, 1), ended.stderr)

    def test_a_recording_has_health_and_clock_of_the_place_that_is_shown(self):
        sensor = self.start(Sensor)
        file = pathlib.Path(self.folder) / "it.mcap"
        made = subprocess.run([*COMMAND, "record", f"127.0.0.1:{sensor.port}", file, "--seconds", "7", "--timeout", "20"], capture_output=True,
                              text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertEqual(sensor.stop(), 0)
        view = self.start(View, file, "--http-port", "0")
        with WebSocket(view.port) as page:
            self.assertTrue(page.wish("play", on=False)["done"])
            uptimes = {}
            for to_ms in (5000, 2000, 5000):
                self.assertTrue(page.wish("seek", to_ms=to_ms)["done"])
                page.until("playback", lambda place, to=to_ms: to <= place["at_ms"] < to + 1500)
                health = page.message("status")["health"]
                self.assertIsNotNone(health, to_ms)
                self.assertEqual(uptimes.setdefault(to_ms, health["uptime_s"]), health["uptime_s"])
            self.assertTrue(1 < uptimes[5000] - uptimes[2000] < 5, uptimes)
            # Both ends, too, as long as they are looked at: behind the last frame it begins anew.
            length = page.told["playback"]["length_ms"]
            for to_ms, least in ((length, uptimes[5000] + 0.5), (0, -1), (length, uptimes[5000] + 0.5)):
                self.assertTrue(page.wish("seek", to_ms=to_ms)["done"])
                page.until("playback", lambda place, to=to_ms: abs(place["at_ms"] - to) < 1500)
                for _ in range(4):
                    health = page.message("status")["health"]
                    self.assertTrue(health or to_ms == 0, to_ms)
                    uptime = health["uptime_s"] if health else 0
                    self.assertTrue(least < uptime < least + 4, (to_ms, uptime, uptimes))
        self.assertEqual(view.stop(), 0)
        cut = pathlib.Path(self.folder) / "cut.mcap"
        cut.write_bytes(file.read_bytes()[:-100])
        view = self.start(View, cut, "--http-port", "0")
        with WebSocket(view.port) as page:
            for _ in range(3):
                place = page.message("playback")
                self.assertFalse(place["seekable"])
                self.assertLess(place["at_ms"], 60_000)
                self.assertLess(abs(place["began_ms"] / 1000 - time.time()), 600)
                self.assertEqual(place["length_ms"], 0)
        self.assertEqual(view.stop(), 0)

    def test_a_recording_with_a_silence_and_a_restart_keeps_both(self):
        sensor = self.start(Sensor, port=lasting_port())
        file = pathlib.Path(self.folder) / "gaps.mcap"
        made = subprocess.Popen([*COMMAND, "record", f"127.0.0.1:{sensor.port}", file, "--timeout", "20"], stdout=subprocess.DEVNULL)
        self.addCleanup(made.kill)
        await_("frames", lambda: file.exists() and file.stat().st_size > 40_000)
        time.sleep(1)
        sensor.process.send_signal(signal.SIGSTOP)
        time.sleep(3)
        sensor.process.send_signal(signal.SIGCONT)
        time.sleep(4)
        sensor.process.kill()
        sensor.process.wait()
        self.start(Sensor, port=sensor.port, name="again")
        time.sleep(4)
        made.send_signal(signal.SIGINT)
        self.assertEqual(made.wait(ENOUGH_S), 0)
        cut = pathlib.Path(self.folder) / "cut.mcap"
        cut.write_bytes(file.read_bytes()[:-100])
        for one, name in ((file, "whole"), (cut, "cut")):
            view = self.start(View, one, "--http-port", "0", name=name)
            with WebSocket(view.port) as page:
                events, waited, end = [], False, time.monotonic() + ENOUGH_S
                while not (waited and all(any(what in event["text"] for event in events) for what in ("sends again", "started again"))):
                    self.assertLess(time.monotonic(), end, events)
                    opcode, payload = page.receive()
                    told = json.loads(payload) if opcode == 1 else {"type": ""}
                    events += [told] if told["type"] == "event" and told["condition"] is None else []
                    waited = waited or bool(told.get("waiting"))
                self.assertTrue(all(before["time_ms"] <= after["time_ms"] for before, after in zip(events, events[1:])), events)
                said = [re.match("link: the sensor (is silent|sends again|started again)", event["text"])[1] for event in events]
                self.assertEqual((said[0], said.count("started again")), ("is silent", 1), events)
                silent = events[0]["time_ms"] - page.told["playback"]["began_ms"]
                again = events[said.index("sends again")]["time_ms"] - page.told["playback"]["began_ms"]
                self.assertGreater(again - silent, 3000, events)
                if one is file:
                    self.look_at_the_silence(page, silent)
                    self.look_at_the_restart(page, next(event["time_ms"] for event in events if "started" in event["text"]))
            self.assertEqual(view.stop(), 0)

    def look_at_the_silence(self, page, silent):
        """It is played at its pace: the place goes on, and the page is told that nothing is there."""
        self.assertTrue(page.wish("play", on=True)["done"])
        self.assertTrue(page.wish("seek", to_ms=silent - 900)["done"])
        page.until("playback", lambda place: silent - 1000 < place["at_ms"] < silent)
        end = time.monotonic() + ENOUGH_S
        for waits in (False, True):  # the newest status may be of before
            while bool(page.message("status")["waiting"]) != waits:
                self.assertLess(time.monotonic(), end)
        began, places = time.monotonic(), []
        while (status := page.message("status"))["waiting"]:
            self.assertRegex(status["waiting"], r"^the recording has nothing here for [2-9]\.\d s$")
            self.assertEqual(status["link"], ["silent"])
            places.append(page.told["playback"]["at_ms"])
        self.assertEqual(status["link"], [])
        self.assertGreater(time.monotonic() - began, 1.5)  # of the 2.7 s in which it is told
        self.assertGreater(len(places), 1)
        self.assertTrue(all(before < after for before, after in zip(places, places[1:])), places)

    def look_at_the_restart(self, page, started):
        """Its first frame has no health of the start before."""
        self.assertTrue(page.wish("play", on=False)["done"])
        to_ms = started - page.told["playback"]["began_ms"]
        self.assertTrue(page.wish("seek", to_ms=to_ms)["done"])
        page.until("playback", lambda place: to_ms <= place["at_ms"] < to_ms + 300)
        for _ in range(3):
            health = page.message("status")["health"]
            self.assertTrue(health is None or health["uptime_s"] < 3, health)

    def test_a_folder_that_cannot_be_written_is_refused_at_once(self):
        sensor = self.start(Sensor)
        folder = pathlib.Path(self.folder) / "closed"
        folder.mkdir(mode=0o555)
        user = 65534 if os.geteuid() == 0 else None  # root may write anywhere
        os.chmod(self.folder, 0o755)
        try:
            ended = subprocess.run([*COMMAND, "view", f"127.0.0.1:{sensor.port}", "--http-port", "0", "--record-to", folder], cwd="/",
                                   user=user, capture_output=True, text=True, timeout=ENOUGH_S, check=False)
        except PermissionError:
            self.skipTest("another user cannot run this build")
        self.assertEqual((ended.returncode, ended.stderr.count("\n")), (2, 1), ended.stderr)
        self.assertIn("--record-to: ", ended.stderr)
        self.assertIn("cannot be written (Permission denied)", ended.stderr)

    def test_a_sensor_named_by_its_name_has_its_settings_read(self):
        name = f"view{os.getpid()}"
        sensor = self.start(Sensor, "--set", f"name={name}", "--set", "discovery.beacon=true", "--set", "discovery.mdns=true")
        found = subprocess.run([*COMMAND, "discover", "--json"], capture_output=True, text=True, timeout=ENOUGH_S, check=False)
        if name not in found.stdout:
            self.skipTest("no network here on which a sensor is found")
        view = self.start(View, name, "--http-port", "0", "--timeout", "20")
        with WebSocket(view.port) as page:
            page.ask("depth")
            page.frame()
            end = time.monotonic() + ENOUGH_S
            while (settings := page.wish("settings") and page.told["settings"])["problem"] and time.monotonic() < end:
                self.assertNotRegex(settings["problem"], "resol|unreachable")
                time.sleep(0.2)
            self.assertEqual(settings["problem"], "")
            self.assertEqual(json.loads(settings["active"])["name"], name)
        self.assertEqual(view.stop(), 0)
        self.assertEqual(sensor.stop(), 0)

    def test_a_recording_that_no_disk_takes_is_not_told_as_made(self):
        sensor = self.start(Sensor)
        limited = ("sh", "-c", "trap '' XFSZ; ulimit -f 40; exec \"$@\"", "_")  # 20,480 bytes
        view = self.start(View, sensor, "--http-port", "0", "--timeout", "20", "--record-to", self.folder, before=limited)
        with WebSocket(view.port) as page:
            page.ask("depth")
            page.frame()
            self.assertTrue(page.wish("record", on=True)["done"])
            while not (state := page.message("recording"))["problem"]:
                self.assertTrue(state["on"] or state["writing"] or not state["file"], state)
            self.assertEqual((state["on"], state["writing"]), (False, False))
            self.assertRegex(state["problem"], "^File too large.*; there is no file$")
            self.assertNotIn(self.folder, state["problem"])
            self.assertFalse(pathlib.Path(state["file"]).exists())
        self.assertEqual(view.stop(), 0)

    def test_headless_writes_pictures_and_serves_nothing(self):
        sensor = self.start(Sensor, "--size", "160x120", "--period-ms", "200")
        out = pathlib.Path(self.folder) / "pictures"
        ended = subprocess.run([*COMMAND, "view", f"127.0.0.1:{sensor.port}", "--timeout", "20", "--frames", "5", "--headless", str(out)],
                               capture_output=True, text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertNotIn("page:", ended.stdout)
        written = int(re.search(r"wrote (\d+) frames? to ", ended.stdout)[1])
        left_out = re.search(r", (\d+) left out: ", ended.stdout)
        self.assertGreater(written, 0)
        self.assertEqual(written + (int(left_out[1]) if left_out else 0), 5, ended.stdout)
        for kind in ("depth", "depth_color"):
            files = sorted(out.glob(f"{kind}_??????????.png"))
            self.assertEqual(len(files), written)
            for file in files:
                self.assertTrue(file.read_bytes().startswith(b"\x89PNG"))

    def test_out_follows_no_link_and_waits_at_no_pipe(self):
        sensor = self.start(Sensor)
        target = pathlib.Path(self.folder) / "target"
        target.write_text("kept", encoding="utf-8")
        for kind, flag, name in (("link", "--out", "left.png"), ("pipe", "--out", "depth.png")):
            out = pathlib.Path(self.folder) / kind
            out.mkdir()
            if kind == "link":
                (out / name).symlink_to(target)
            else:
                os.mkfifo(out / name)
            ended = subprocess.run([*COMMAND, "view", f"127.0.0.1:{sensor.port}", "--timeout", "20", "--frames", "1", flag, str(out)],
                                   capture_output=True, text=True, timeout=ENOUGH_S, check=False)
            self.assertEqual((ended.returncode, ended.stderr.count("\n")), (1, 1), ended.stderr)
            self.assertIn(f"{name}: cannot be written: ", ended.stderr)
        self.assertEqual(target.read_text(encoding="utf-8"), "kept")

    def test_it_ends_with_the_pipe_that_it_prints_to(self):
        sensor = self.start(Sensor)
        view = subprocess.Popen([*COMMAND, "view", f"127.0.0.1:{sensor.port}", "--http-port", "0"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(view.kill)
        while not (line := view.stdout.readline()).startswith("page: "):
            self.assertTrue(line, "it ended")
        view.stdout.close()
        self.assertEqual(view.wait(ENOUGH_S), 1)

    def test_a_port_that_is_taken(self):
        sensor = self.start(Sensor)
        view = self.start(View, sensor, "--http-port", "0")
        ended = subprocess.run([*COMMAND, "view", f"127.0.0.1:{sensor.port}", "--http-port", str(view.port)],
                               capture_output=True, text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual((ended.returncode, ended.stderr.count("\n")), (2, 1), ended.stderr)
        self.assertIn(f"TCP port {view.port} cannot be had", ended.stderr)


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=[sys.argv[0]], verbosity=2)
