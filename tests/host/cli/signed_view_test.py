#!/usr/bin/env python3
"""signed_view_test.py COMMAND...: `stof view --signed` (COMMAND: stof, with an emulator before it in a cross build) of `stofd`
(STOFD holds that command, its words separated by |), with somebody between who forges."""

import collections
import json
import os
import pathlib
import re
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "host/python"))
import stof_wire as wire  # noqa: E402

COMMAND = []
STOFD = [word for word in os.environ.get("STOFD", "").split("|") if word]
ENOUGH_S = 60
SIGNED_HEADER = 80


def unsigned(datagram, **fields):
    """The same in the sensor's name, without a signature."""
    header, payload = wire.parse(datagram)
    for name, value in fields.items():
        setattr(header, name, value)
    return wire.seal(header, payload)


def changed(datagram):
    """With another frame number, and the check sum right."""
    packet = bytearray(datagram[:-wire.CRC_BYTES])
    packet[20] ^= 0x55
    return bytes(packet) + wire.crc32c(packet).to_bytes(wire.CRC_BYTES, "little")


class Between(threading.Thread):
    """Passes what a client and a sensor say; what the sensor sends goes through `work`: one datagram in, any out. `due` says
    when a datagram that came so many seconds after the first one leaves, all in their order."""

    def __init__(self, port, work, due=lambda came: came):
        super().__init__(daemon=True)
        self.due = due
        self.began = None
        self.waiting = collections.deque()
        self.client = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.client.bind(("127.0.0.1", 0))
        self.sensor = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sensor.connect(("127.0.0.1", port))
        self.sensor.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self.port = self.client.getsockname()[1]
        self.work = work
        self.ended = False
        self.start()

    def run(self):
        client = None
        while not self.ended:
            self.release(client)
            for ready in select.select([self.client, self.sensor], [], [], 0.002 if self.waiting else 0.05)[0]:
                try:
                    if ready is self.client:
                        datagram, client = self.client.recvfrom(2048)
                        self.sensor.send(datagram)
                    elif client is not None:
                        datagrams = self.work(self.sensor.recv(2048))
                        now = time.monotonic()
                        self.began = self.began or now
                        self.waiting.extend((self.began + self.due(now - self.began), out) for out in datagrams)
                except OSError:
                    pass
            self.release(client)

    def release(self, client):
        while self.waiting and self.waiting[0][0] <= time.monotonic():
            try:
                self.client.sendto(self.waiting.popleft()[1], client)
            except OSError:
                pass

    def end(self):
        self.ended = True
        self.join()
        self.client.close()
        self.sensor.close()


class SignedView(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.keys = self.folder / "user"
        self.assertEqual(self.stof("pair", "--into", self.folder / "sensor", "--keys", self.keys, "--role", "view").returncode, 0)
        port = self.folder / "port"
        self.sensor = subprocess.Popen(
            [*STOFD, "--size", "64x48", "--pmd", "none", "--period-ms", "80", "--port", "0", "--port-file", port, "--keys", self.folder / "sensor",
             "--set", "discovery.mdns=false", "--set", "discovery.beacon=false", "--set", "streams.parity=true"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(self.stop)
        end = time.monotonic() + ENOUGH_S
        while not (port.exists() and port.read_text(encoding="utf-8").endswith("\n")):
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)
        self.port = int(port.read_text(encoding="utf-8"))

    def stop(self):
        self.sensor.kill()
        self.sensor.wait()

    @staticmethod
    def stof(*words):
        return subprocess.run([*COMMAND, *map(str, words)], capture_output=True, text=True, timeout=ENOUGH_S, check=False)

    def view(self, port, *words):
        return self.stof("view", f"127.0.0.1:{port}", *words)

    def between(self, work, **more):
        between = Between(self.port, work, **more)
        self.addCleanup(between.end)
        return between.port

    def test_sees_what_the_sensor_signs(self):
        seen = self.view(self.port, "--signed", "--keys", self.keys, "--frames", 30)
        self.assertEqual((seen.returncode, seen.stderr), (0, ""), seen.stdout)
        self.assertIn("30 frames received, 30 verified whole", seen.stdout)
        self.assertNotIn("not signed", seen.stdout)
        self.assertNotIn("forged traffic", seen.stdout)

    def test_who_stands_between_forges_in_vain_and_is_told(self):
        count = [0]

        def forge(datagram):
            count[0] += 1
            if wire.parse(datagram)[0].type >= 128:
                return [datagram]
            kind = count[0] % 5
            extra = {1: lambda: [unsigned(datagram)], 2: lambda: [changed(datagram)], 3: lambda: [datagram],
                     4: lambda: [unsigned(datagram, number=wire.parse(datagram)[0].number + 1)]}
            return [*(extra[kind]() if kind in extra else ()), datagram]

        seen = self.view(self.between(forge), "--signed", "--keys", self.keys, "--frames", 40)
        self.assertEqual((seen.returncode, seen.stderr), (0, ""), seen.stdout)
        self.assertIn("40 frames received, 40 verified whole", seen.stdout)
        for told in (r"[1-9]\d* packets not signed for this program", r"[1-9]\d* packets with a wrong signature",
                     r"[1-9]\d* packets twice", "link:.* forged traffic"):
            self.assertRegex(seen.stdout, told)

    def test_without_signatures_the_same_is_believed(self):
        def strip(datagram):
            return [unsigned(datagram) if wire.parse(datagram)[0].header_length >= SIGNED_HEADER else datagram]

        seen = self.view(self.between(strip), "--signed", "--keys", self.keys, "--frames", 10, "--timeout", 2)
        self.assertEqual(seen.returncode, 1, seen.stdout)
        self.assertRegex(seen.stderr, r"packets came, but no frame.*not signed for this program")
        self.assertEqual(self.view(self.between(strip), "--frames", 10).returncode, 0)

    def test_no_document_and_no_announcement_is_believed_without_either(self):
        false = b'{"name":"elsewhere"}'

        def lie(datagram):
            header, payload = wire.parse(datagram)
            if header.type == wire.PacketType.SETTINGS_ANSWER:
                answer = wire.SettingsAnswer.unpack(payload)
                answer.result, answer.total = wire.SettingsResult.OK, len(false)
                return [wire.seal(header, answer.pack() + false), datagram]
            if header.type == wire.PacketType.ANNOUNCE:
                announce = wire.Announce.unpack(payload)
                announce.name, announce.serial = "elsewhere", "00000009"
                mine = wire.seal(header, announce.pack())
                header.origin = wire.Origin(device_id=9, session_id=1)
                return [wire.seal(header, announce.pack()), mine, datagram]
            return [datagram]

        port = self.between(lie)
        seen = self.stof("info", f"127.0.0.1:{port}", "--signed", "--keys", self.keys, "--json")
        self.assertEqual((seen.returncode, seen.stderr), (0, ""), seen.stdout)
        info = json.loads(seen.stdout)
        self.assertEqual((info["device_id"], info["identity"]["serial"], info["identity"]["name"]), (1, "00000001", "stof"))
        self.assertEqual(info["settings"]["name"], "stof")
        self.assertIn("board", info["identity"]["unsigned"])
        # Who asks for no signature believes the first that answers.
        self.assertEqual(json.loads(self.stof("info", f"127.0.0.1:{port}", "--json").stdout)["settings"]["name"], "elsewhere")
        file = self.folder / "it.mcap"
        recorded = self.stof("record", f"127.0.0.1:{port}", file, "--frames", 3, "--signed", "--keys", self.keys)
        self.assertEqual(recorded.returncode, 0, recorded.stderr)
        self.assertEqual(json.loads(self.stof("info", file, "--json").stdout)["sensor"]["settings"], "attachment settings.json")
        attached = file.read_bytes()
        self.assertIn(b'"name": "stof"', attached)
        self.assertNotIn(b"elsewhere", attached)

    def test_a_way_that_takes_longer_than_a_request_waits_is_no_obstacle(self):
        seen = self.view(self.between(lambda datagram: [datagram], due=lambda came: came + 0.35), "--signed", "--keys", self.keys,
                         "--frames", 10)
        self.assertEqual(seen.returncode, 0, seen.stdout + seen.stderr)
        self.assertNotIn("forged traffic", seen.stdout)
        port = self.between(lambda datagram: [datagram], due=lambda came: came + 0.35)
        for keys in (self.keys, self.folder / "none"):
            read = self.stof("config", f"127.0.0.1:{port}", "get", "name", "--keys", keys, "--device", 1)
            self.assertEqual((read.returncode, read.stdout.strip()), (0, "stof"), read.stderr)

    def test_a_stream_that_is_slowed_is_refused_however_long_it_goes_on(self):
        for seconds in (6, 60):  # 37 frames of 75, the last of them three seconds old; a busy machine has fewer
            port = self.between(lambda datagram: [datagram], due=lambda came: came / 0.5)
            view = subprocess.Popen([*COMMAND, "view", f"127.0.0.1:{port}", "--signed", "--keys", str(self.keys)],
                                    stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            time.sleep(seconds)
            view.send_signal(signal.SIGINT)
            out, error = view.communicate(timeout=ENOUGH_S)
            received = re.search(r"(\d+) frames received", out)  # none by then: a very busy machine
            self.assertLess(int(received[1]) if received else 0, 10, out + error)
            late = sum(map(int, re.findall(r"(\d+) frames too old", out)))
            if late > 15:
                break
        self.assertGreater(late, 15, out)
        self.assertRegex(out, "link:.* delayed")

    def test_a_way_that_became_longer_is_taken_when_a_new_key_proves_it(self):
        port = self.between(lambda datagram: [datagram], due=lambda came: came + (0.23 if came > 1.5 else 0))
        seen = self.view(port, "--signed", "--keys", self.keys, "--frames", 50)
        self.assertEqual((seen.returncode, seen.stderr), (0, ""), seen.stdout)
        self.assertGreater(int(re.search(r"(\d+) frames too old", seen.stdout)[1]), 5, seen.stdout)
        self.assertRegex(seen.stdout, "link:.* delayed")

    def test_without_a_key_it_says_what_to_do(self):
        seen = self.view(self.port, "--signed", "--keys", self.folder / "none", "--frames", 10, "--timeout", 1)
        self.assertEqual(seen.returncode, 1)
        self.assertIn("no key of yours is one of this sensor", seen.stderr)
        self.assertRegex(self.stof("view", "--signed").stderr, "--signed: takes a SENSOR")
        self.assertEqual(self.stof("view", "--signed").returncode, 2)


if __name__ == "__main__":
    COMMAND = sys.argv[1:]
    unittest.main(argv=sys.argv[:1])
