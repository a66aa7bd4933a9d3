#!/usr/bin/env python3
"""view_page_test.py COMMAND...: the server of `stof view` (COMMAND: stof) with a WebSocket client in place of a browser. STOFD
and STOF_EMU_PAIR hold these commands, their words separated by |."""

import json
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import unittest
import unittest.mock

from web_client import BINARY, Closed, Refused, WebSocket, get, request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from udp_ports import lasting_port  # noqa: E402

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
ENOUGH_S = 60
WIDTH, HEIGHT = 64, 48
MOST_PAGES = 8
ROOT = pathlib.Path(__file__).resolve().parents[3]


def await_(what, condition):
    end = time.monotonic() + ENOUGH_S
    while not condition():
        if time.monotonic() > end:
            raise AssertionError(f"{what}: did not come")
        time.sleep(0.02)


def is_done(answer):
    return answer["done"]


class Program:
    """A program that runs until stop(); its lines."""

    def __init__(self, words, folder, name):
        self.log = pathlib.Path(folder) / f"{name}.log"
        with self.log.open("w", encoding="utf-8") as log:
            self.process = subprocess.Popen([*map(str, words)], stdout=log, stderr=subprocess.STDOUT)

    def text(self):
        return self.log.read_text(encoding="utf-8")

    def stop(self):
        """Its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        return self.process.wait(ENOUGH_S)


class Sensor(Program):
    def __init__(self, folder, *flags, port=0, name="sensor"):
        port_file = pathlib.Path(folder) / f"{name}.port"
        port_file.unlink(missing_ok=True)
        super().__init__([*STOFD, "--scene", "room:3", "--seed", "1", "--size", f"{WIDTH}x{HEIGHT}", "--pmd", "32x24", "--period-ms", "100", "--port",
                          port, "--port-file", port_file, "--set", "discovery.mdns=false", "--set", "discovery.beacon=false", "--set",
                          "streams.grey_left=rvl", "--set", "streams.depth=rvl", *flags], folder, name)
        await_("the sensor's port", lambda: port_file.exists() and port_file.read_text(encoding="utf-8").endswith("\n"))
        self.port = int(port_file.read_text(encoding="utf-8"))


class View(Program):
    """sensor: what has a port, or what `stof view` takes. before: words before the command."""

    def __init__(self, folder, sensor, *flags, name="view", before=()):
        where = f"127.0.0.1:{sensor.port}" if hasattr(sensor, "port") else sensor
        super().__init__([*before, *COMMAND, "view", where, *flags], folder, name)
        await_("the page's address", lambda: re.search(r"^page: .*\n", self.text(), re.M) or self.process.poll() is not None)
        self.addresses = re.findall(r"^page: (http://\S+)\n", self.text(), re.M)
        assert self.addresses, self.text()
        self.port = int(re.match(r"http://127\.0\.0\.1:(\d+)/", self.addresses[0])[1])


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


class Ways(unittest.TestCase):
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
        sensor = self.start(Sensor)
        out = pathlib.Path(self.folder) / "pictures"
        ended = subprocess.run([*COMMAND, "view", f"127.0.0.1:{sensor.port}", "--timeout", "20", "--frames", "5", "--headless", str(out)],
                               capture_output=True, text=True, timeout=ENOUGH_S, check=False)
        self.assertEqual(ended.returncode, 0, ended.stderr)
        self.assertNotIn("page:", ended.stdout)
        written = int(re.search(r"wrote (\d+) frames to ", ended.stdout)[1])
        self.assertGreater(written, 0)
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
