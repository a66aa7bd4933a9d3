#!/usr/bin/env python3
"""view_page_test.py COMMAND...: the server of `stof view` (COMMAND: stof) with a WebSocket client in place of a browser. STOFD
holds that program's command, its words separated by |."""

import json
import os
import pathlib
import re
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

from view_programs import COMMAND, ENOUGH_S, HEIGHT, MOST_PAGES, WIDTH, Sensor, View, await_, is_done
from web_client import BINARY, Closed, Refused, WebSocket, get, request

ROOT = pathlib.Path(__file__).resolve().parents[3]


class Pages(unittest.TestCase):
    """One sensor and one `stof view` for all of them."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory(prefix="stof_")
        cls.addClassCleanup(cls.folder.cleanup)
        # Nobody's keys.
        environment = unittest.mock.patch.dict(os.environ, {"XDG_CONFIG_HOME": cls.folder.name})
        environment.start()
        cls.addClassCleanup(environment.stop)
        cls.faults = pathlib.Path(cls.folder.name) / "faults"
        cls.recordings = pathlib.Path(cls.folder.name) / "recordings"
        cls.recordings.mkdir()
        cls.sensor = Sensor(cls.folder.name, "--fault-socket", cls.faults)
        cls.addClassCleanup(cls.sensor.stop)
        cls.view = View(cls.folder.name, cls.sensor, "--http-port", "0", "--timeout", "20", "--fault-socket", cls.faults, "--record-to",
                        cls.recordings)
        cls.addClassCleanup(cls.view.stop)
        cls.port = cls.view.port

    def open(self, **how):
        """Waits for a place: a page that has just ended may still have it."""
        end = time.monotonic() + ENOUGH_S
        while True:
            try:
                page = WebSocket(self.port, **how)
                self.addCleanup(page.close)
                return page
            except Refused as refused:
                if refused.status != 503 or time.monotonic() > end:
                    raise
                time.sleep(0.05)

    def test_the_page_is_one_document_that_loads_nothing(self):
        status, answer = get(self.port)
        self.assertEqual(status, 200)
        head, _, body = answer.partition(b"\r\n\r\n")
        head = head.decode().lower()
        for line in ("cache-control: no-store", "x-content-type-options: nosniff", "x-frame-options: deny", "referrer-policy: no-referrer"):
            self.assertIn(line, head)
        policy = re.search(r"content-security-policy: (.*)\r?", head)[1]
        self.assertTrue(policy.startswith("default-src 'none'"))
        self.assertNotIn("unsafe", policy)
        self.assertNotRegex(body.decode(), r"""(?:src|href)=["']?(?:https?:)?//""")

    def test_hosts_that_are_not_this_machine_are_refused(self):
        for host in ("evil.example", "evil.example:80", "127.0.0.1.evil.example", "192.168.7.7", "localhost.", "localhost:x", "127.0.0.1:", "[::1",
                     "localhost:80:80", "0x7f000001", "[::2]", "127.0.0.1:999999", " "):
            with self.subTest(host):
                self.assertIn(get(self.port, host=host)[0], (0, 400, 403))
                with self.assertRaises(Refused):
                    WebSocket(self.port, host=host, origin=f"http://{host}")
        self.assertEqual(request(self.port, "GET / HTTP/1.0\r\n\r\n")[0], 403)
        for host in ("localhost", "LOCALHOST:1", "127.0.0.1:1", "[::1]:1"):
            self.assertEqual(get(self.port, host=host)[0], 200, host)

    def test_pages_of_other_sites_are_refused(self):
        for origin in ("http://evil.example", "null", f"https://127.0.0.1:{self.port}", "http://127.0.0.1:1", f"http://localhost:{self.port}",
                       "file://"):
            with self.subTest(origin):
                self.assertEqual(get(self.port, Origin=origin)[0], 403)
                with self.assertRaises(Refused) as refused:
                    WebSocket(self.port, origin=origin)
                self.assertEqual(refused.exception.status, 403)
        self.open(origin="").close()  # no browser

    def test_what_is_no_request_for_the_page_is_refused(self):
        self.assertEqual(get(self.port, "/other")[0], 404)
        self.assertEqual(get(self.port, "/../../etc/passwd")[0], 404)
        for method in ("POST", "PUT", "DELETE", "HEAD"):
            self.assertNotEqual(get(self.port, method=method, Content_Length="0")[0], 200, method)
        self.assertNotEqual(get(self.port, "/" + "a" * 100_000)[0], 200)
        self.assertNotEqual(get(self.port, Large="a" * 100_000)[0], 500)
        self.assertNotEqual(request(self.port, "\x00\xff nothing\r\n\r\n")[0], 200)
        with self.assertRaises(Refused) as refused:
            WebSocket(self.port, subprotocol="other")
        self.assertEqual(refused.exception.status, 400)
        self.assertEqual(get(self.port)[0], 200)

    def test_messages_that_mean_nothing_end_the_connection(self):
        for payload, status in ((b"", 1008), (b"{}", 1008), (b"[" * 1000, 1008), (b"\xff", None), (b'{"show":["depth"],"frames":3,"quiet":false}', 1008),
                                (b'{"show":["x"],"frames":1,"quiet":false}', 1008), (b'{"show":["depth"],"frames":-1,"quiet":false}', 1008),
                                (b'{"show":"depth","frames":1,"quiet":false}', 1008), (b'{"show":[1],"frames":1,"quiet":false}', 1008),
                                (b'{"show":[],"frames":1,"quiet":0}', 1008), (b'{"show":[],"frames":1,"quiet":true,"more":1}', 1008),
                                (b'{"do":"format","id":1,"ticket":""}', 1008), (b'{"do":"save"}', 1008),
                                (b'{"do":"seek","id":1,"ticket":"","to_ms":-1}', 1008), (b" " * 2049, 1009), (b" " * 100_000, 1009)):
            with self.subTest(payload[:60]), self.open() as page:
                with self.assertRaises((Closed, ConnectionError)) as closed:
                    page.send(payload)
                    while True:
                        page.receive()
                if status and isinstance(closed.exception, Closed):
                    self.assertIn(closed.exception.status, (status, 0))
        with self.open() as page:
            page.send(b'{"show":[],"frames":0,"quiet":true}', BINARY)
            with self.assertRaises(Closed):
                while True:
                    page.receive()
        with self.open() as page:  # in parts that never end
            with self.assertRaises((Closed, ConnectionError)):
                page.send(b" " * 100, final=False)
                for _ in range(100):
                    page.send(b" " * 100, 0, final=False)
                while True:
                    page.receive()

    def test_a_page_gets_what_it_asks_for_and_nothing_else(self):
        with self.open() as page:
            hello = page.message("hello")
            self.assertEqual(len(hello["colours"]), 1024)
            self.assertEqual([source["name"] for source in hello["sources"]], ["none", "stereo", "pmd", "both", "resolved", "conflict"])
            page.ask("depth", "width", "source", "left")
            head, planes = page.frame()
            self.assertEqual((head["size"], head["left_size"], head["planes"]),
                             ([WIDTH, HEIGHT], [WIDTH, HEIGHT], ["depth", "width", "source", "left"]))
            depth = struct.unpack(f"<{WIDTH * HEIGHT}H", planes["depth"])
            self.assertGreater(sum(value > 0 for value in depth), WIDTH * HEIGHT // 2)
            self.assertTrue(all(source in range(6) for source in planes["source"]))
            self.assertGreater(len(set(planes["left"])), 10)
            numbers = [head["frame"]]
            for _ in range(5):
                page.ask("depth")
                head, planes = page.frame()
                self.assertEqual(list(planes), ["depth"])
                numbers.append(head["frame"])
            self.assertEqual(sorted(set(numbers)), numbers)
            while (status := page.message("status"))["link"] or not status["health"]:
                pass  # a slow machine is silent at times
            self.assertEqual(status["waiting"], "")
            self.assertGreater(status["frames"], 0)
            self.assertIn("unpaired", [one["name"] for one in status["health"]["active"]])
            # Not asked: it gets none. What comes next is a status that was told later than this one.
            page.message("status")
            page.ask(frames=2)
            page.message("status")
            self.assertEqual(page.receive()[0], 1)

    def test_a_slow_page_skips_frames_and_gets_the_newest(self):
        with self.open(receive_buffer=4096) as slow, self.open() as fast:
            slow.ask("depth", frames=2)
            fast.ask("depth", frames=2)
            newest = 0
            for _ in range(20):
                newest = fast.frame()[0]["frame"]
                fast.ask("depth")
            first, second = slow.frame()[0]["frame"], slow.frame()[0]["frame"]
            self.assertLess(second, newest)  # asked for long ago: these two were on the way
            slow.ask("depth")
            self.assertGreaterEqual(slow.frame()[0]["frame"], newest)  # what came meanwhile was never sent
            self.assertLess(first, second)

    def test_what_a_page_wants_takes_its_ticket_and_an_origin(self):
        change = {"settings": {"streams.cloud_step": 16}}
        with self.open() as page, self.open() as other:
            self.assertNotEqual(page.until("rights")["ticket"], other.until("rights")["ticket"])
            foreign = "0" * 32
            for wrong in ("", foreign):
                answer = page.wish("set", wrong, 3, **change)
                self.assertEqual((answer["id"], answer["done"]), (3, False))
        with self.open(origin="") as page:
            rights = page.until("rights")
            self.assertEqual((rights["may"], rights["ticket"]), (False, ""))
            self.assertFalse(page.wish("set", "", **change)["done"])
        with self.open() as page:
            self.assertIn("load it again", page.wish("set", foreign, **change)["text"])
            self.assertEqual(self.setting("streams.cloud_step"), "8")
            with self.assertRaises((Closed, ConnectionError)):
                for number in range(10_000):
                    page.want("save", foreign, number)
                while True:
                    page.receive()

    def setting(self, path):
        return subprocess.run([*COMMAND, "config", f"127.0.0.1:{self.sensor.port}", "get", path, "--timeout", "10"], capture_output=True, text=True,
                              timeout=ENOUGH_S, check=True).stdout.strip()

    def answer_when(self, page, good, what, **members):
        """The first answer that is good: the page's program waits a second for the sensor's, and a busy machine may take more."""
        end = time.monotonic() + ENOUGH_S
        while not good(answer := page.wish(what, **members)) and time.monotonic() < end:
            time.sleep(0.2)
        self.assertTrue(good(answer), answer)
        return answer

    def test_settings_are_changed_by_one_request_and_refused_in_the_sensors_words(self):
        with self.open() as page:
            page.until("pairing", lambda told: told["offer"] == "unpaired")  # the sensor has said so
            self.answer_when(page, is_done, "settings")  # once it knows where the sensor is
            with self.open() as late:  # whoever comes later has it, too
                settings = late.message("settings")
            self.assertEqual((settings["problem"], settings["doubt"], settings["role"]), ("", "", "anybody"))
            self.assertEqual(json.loads(settings["schema"])["properties"]["streams"]["properties"]["cloud_step"]["maximum"], 64)
            answer = self.answer_when(page, is_done, "set", number=9, settings={"streams.cloud_step": 32, "streams.parity": True})
            self.assertRegex(answer["text"], r"^revision \d+.*in force, until the next start$")  # nobody may save it
            self.assertEqual((self.setting("streams.cloud_step"), self.setting("streams.parity")), ("32", "true"))
            for refused, words in (({"streams.cloud_step": 1}, "streams.cloud_step: takes 2 to 64"), ({"moon": 1}, "moon"),
                                   ({"streams.cloud_step": 8, "depth.preset": "quality"}, "depth.preset"), ({"name": "x"}, "name")):
                answer = self.answer_when(page, lambda answer, words=words: words in answer["text"], "set", settings=refused)
                self.assertFalse(answer["done"])
            self.assertEqual(self.setting("streams.cloud_step"), "32")  # none of it
            self.assertFalse(page.wish("save")["done"])
            self.answer_when(page, is_done, "set", settings={"streams.cloud_step": 8, "streams.parity": False})

    def test_a_fault_is_given_by_page_and_command_line(self):
        def active(page):
            return [one["name"] for one in (page.message("status")["health"] or {"active": []})["active"]]

        with self.open() as page:
            self.answer_when(page, is_done, "fault", device="pmd", kind="vanish", edges=0)
            while "pmd_lost" not in active(page):
                pass
            page.until("faults", lambda told: ("pmd", "vanish", 0) in [(one["device"], one["now"], one["edges"]) for one in told["devices"]])
            self.answer_when(page, is_done, "fault", device="pmd", kind="none", edges=0)
            while "pmd_lost" in active(page):
                pass
            answer = self.answer_when(page, lambda answer: "no such fault of stereo" in answer["text"], "fault", device="stereo", kind="dark",
                                      edges=0)
            self.assertFalse(answer["done"])

        def fault(*words):
            end = time.monotonic() + ENOUGH_S
            while True:
                ended = subprocess.run([*COMMAND, "fault", *map(str, words)], capture_output=True, text=True, timeout=ENOUGH_S, check=False)
                if "does not answer" not in ended.stderr or time.monotonic() > end:  # within a second
                    break
            self.assertEqual(ended.stderr.count("\n"), 0 if ended.returncode == 0 else 1, ended.stderr)
            return ended.returncode, ended.stdout + ended.stderr

        self.assertEqual(self.faults.stat().st_mode & 0o777, 0o600)
        self.assertEqual(fault(self.faults, "pmd:dark:1000000"), (0, unittest.mock.ANY))
        code, said = fault(self.faults, "--json")
        self.assertEqual(code, 0)
        self.assertEqual({one["device"]: one["fault"] for one in json.loads(said)}, {"trigger": "none", "stereo": "none", "pmd": "dark"})
        self.assertEqual(fault(self.faults, "pmd:none")[0], 0)
        for words, code, what in (((self.faults, "moon:drop"), 2, "no such device"), ((self.faults, "pmd:drop:0"), 2, "EDGES"),
                                  ((self.faults, "x" * 300), 2, "256 bytes"), ((self.recordings / "none", ), 1, "no emulated sensor")):
            self.assertEqual(fault(*words), (code, unittest.mock.ANY))
            self.assertIn(what, fault(*words)[1])

    def test_a_page_records(self):
        with self.open() as page:
            self.assertTrue(page.wish("record", on=True)["done"])
            self.assertFalse(page.wish("record", on=True)["done"])  # it does already
            while (state := page.message("recording"))["frames"] < 3:
                self.assertEqual((state["on"], state["problem"]), (True, ""))
            self.assertTrue(page.wish("record", on=False)["done"])
            while (state := page.message("recording"))["on"]:
                pass
            file = pathlib.Path(state["file"])
            self.assertEqual(file.parent, self.recordings)
            self.assertFalse(page.wish("seek", to_ms=0)["done"])

            def info():
                return subprocess.run([*COMMAND, "info", file, "--json"], capture_output=True, text=True, timeout=ENOUGH_S, check=False)

            await_("the file's end", lambda: info().returncode == 0)
            self.assertGreaterEqual(json.loads(info().stdout)["frames"], 3)

    def test_foxglove_gets_messages_of_each_channel_under_both_names(self):
        def cdr_size(schema, payload):
            """Of an image or a cloud: what the message says against what it holds."""
            self.assertEqual(payload[:4], bytes([0, 1, 0, 0]))
            at = 4 + 8 + 4 + struct.unpack_from("<I", payload, 12)[0]
            at += -at % 4
            height, width = struct.unpack_from("<II", payload, at)
            if schema == "sensor_msgs/msg/Image":
                self.assertEqual((width, height), (WIDTH, HEIGHT))
                self.assertEqual(payload[at + 12:at + 18], b"16UC1\0")
                return len(payload) - (at + 28) == 2 * width * height
            return height == 1 and 0 < width <= WIDTH * HEIGHT // 16

        for offered, chosen in (("foxglove.sdk.v1", "foxglove.sdk.v1"), ("foxglove.websocket.v1", "foxglove.websocket.v1"),
                                ("foxglove.websocket.v1, foxglove.sdk.v1", "foxglove.websocket.v1")):
            with self.open(subprotocol=offered, origin="") as client:
                self.assertEqual(client.subprotocol, chosen)
                self.assertEqual(json.loads(client.receive()[1])["op"], "serverInfo")
                channels = {one["id"]: one for one in json.loads(client.receive()[1])["channels"]}
                self.assertEqual(len(channels), 5)
                client.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": 100 + id_, "channelId": id_} for id_ in channels]}).encode())
                seen = {}
                diagnostics = b""
                while set(seen) != set(channels) or seen[1] < 3 or b"rate_millihertz" not in diagnostics:  # health is told
                    opcode, payload = client.receive()
                    self.assertEqual(opcode, BINARY, payload)
                    code, subscription, at_ns = struct.unpack_from("<BIQ", payload)
                    self.assertEqual(code, 1)
                    self.assertLess(abs(at_ns / 1e9 - time.time()), ENOUGH_S)
                    schema = channels[subscription - 100]["schemaName"]
                    if schema in ("sensor_msgs/msg/Image", "sensor_msgs/msg/PointCloud2"):
                        self.assertTrue(cdr_size(schema, payload[13:]), schema)
                    seen[subscription - 100] = seen.get(subscription - 100, 0) + 1
                    if schema == "diagnostic_msgs/msg/DiagnosticArray":
                        diagnostics = payload
                self.judge_layout({one["topic"] for one in channels.values()}, diagnostics)
        # What another site, or nobody's rules, would do.
        for how, status in (({"origin": "https://app.foxglove.dev"}, 403), ({"host": "evil.example", "origin": ""}, 403)):
            with self.assertRaises(Refused) as refused:
                WebSocket(self.port, subprotocol="foxglove.sdk.v1", **how)
            self.assertEqual(refused.exception.status, status)
        with self.open(subprotocol="foxglove.sdk.v1", origin="") as client, self.assertRaises(Closed) as closed:
            client.send(b"{}")
            while True:
                client.receive()
        self.assertEqual(closed.exception.status, 1008)

    def judge_layout(self, topics, diagnostics):
        """What docs/viewer/foxglove_layout.json shows is there, in colours of the page's scale."""
        layout = json.loads((ROOT / "docs/viewer/foxglove_layout.json").read_text(encoding="utf-8"))
        panels = layout["configById"]
        self.assertEqual(sorted(re.findall(r'"(?:first|second)": "([^"]+)"', json.dumps(layout["layout"]))), sorted(panels))
        shown = set()
        for name, panel in panels.items():
            shown |= set(panel.get("topics", {}))
            shown |= {value for key, value in (panel | panel.get("imageMode", {})).items() if key in ("imageTopic", "calibrationTopic", "topicToRender")}
            for path in panel.get("paths", []):
                topic, status, key = re.fullmatch(r'(/\w+)\.status\[:]\{name=="([^"]+)"}\.values\[:]\{key=="(\w+)"}\.value', path["value"]).groups()
                shown.add(topic)
                for text in (status, key):
                    self.assertIn(text.encode() + b"\0", diagnostics, name)
        self.assertEqual(shown | {"/tf_static"}, topics)
        with self.open() as page:
            colours = page.message("hello")["colours"]
        for colour in re.findall(r'"(#[0-9a-f]{6})"', json.dumps(panels)):
            self.assertIn(colour, colours)

    def test_a_hundred_pages_are_served_or_refused(self):
        open_, refused = [], 0
        for _ in range(100):
            try:
                open_.append(WebSocket(self.port))
            except Refused as one:
                self.assertIn(one.status, (503, 0))
                refused += 1
        self.assertLessEqual(len(open_), MOST_PAGES)
        self.assertEqual(len(open_) + refused, 100)
        for page in open_:
            page.ask("depth")
            page.frame()
            page.close()
        with self.open() as page:
            page.ask("depth")
            page.frame()

    def test_connections_that_say_nothing_keep_nobody_out(self):
        silent = []
        try:
            for number in range(300):
                silent.append(socket.create_connection(("127.0.0.1", self.port), ENOUGH_S))
                if number % 3 == 0:
                    silent[-1].sendall(b"GET / HTTP/1.1\r\nHost: ")  # nor those that begin
            begun = time.monotonic()
            self.assertEqual(get(self.port)[0], 200)
            with self.open() as page:
                page.ask("depth")
                page.frame()
            # Before any of them was given up for its silence, one after the other; 40 s it was where they held all places.
            self.assertLess(time.monotonic() - begun, 20)
            # And they are given up.
            silent[-1].settimeout(ENOUGH_S)
            try:
                self.assertEqual(silent[-1].recv(1), b"")
            except ConnectionError:
                pass
        finally:
            for one in silent:
                one.close()

    def test_a_client_that_does_not_mask_is_refused(self):
        for first in (False, True):
            with self.open() as page:
                page.message("hello")
                if not first:
                    page.ask("depth")
                    page.frame()
                with self.assertRaises(Closed) as closed:
                    page.send(b'{"show":["depth"],"frames":1,"quiet":false}', masked=False)
                    end = time.monotonic() + ENOUGH_S
                    while time.monotonic() < end:
                        page.receive()
                self.assertEqual(closed.exception.status, 1002)

    def test_a_second_request_of_a_connection_is_not_answered(self):
        lines = f"GET /other HTTP/1.1\r\nHost: 127.0.0.1:{self.port}\r\n\r\n"
        with socket.create_connection(("127.0.0.1", self.port), ENOUGH_S) as connection:
            connection.sendall((lines * 2).encode())
            answer = b""
            while part := connection.recv(65536):
                answer += part
        self.assertEqual(answer.count(b"HTTP/1.1 404"), 1)


if __name__ == "__main__":
    COMMAND.extend(sys.argv[1:])
    unittest.main(argv=[sys.argv[0]], verbosity=2)
