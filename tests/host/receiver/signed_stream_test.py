#!/usr/bin/env python3
"""signed_stream_test.py -- STOFD...: a stranger's receiver with a key gets datagrams that are signed for it alone."""

import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import signed
from signed import wire

COMMAND = []
KEYS = {7: bytes(range(32)), 8: bytes(range(1, 33))}
DEVICE = 1


def key_file(folder):
    path = pathlib.Path(folder, "keys")
    text = "stof keys 1\n" + "".join(f"{number:08x} {DEVICE:08x} view {secret.hex()} test\n" for number, secret in KEYS.items())
    path.touch(mode=0o600)
    path.write_text(text + f"crc32c {wire.crc32c(text.encode()):08x}\n")
    return path


class Receiver:
    """One subscriber, with a key or without."""

    def __init__(self, port, key_id=None):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self.socket.settimeout(10)
        self.socket.connect(("127.0.0.1", port))
        self.key_id = key_id
        self.counter = time.time_ns() // 1000
        self.number = self.key = None
        self.origin, self.cookie = self.ask(wire.Subscribe(request_id=1))[:2]
        self.subscribe()

    def close(self):
        self.socket.close()

    def subscribe(self, has=0):
        request = wire.Subscribe(request_id=2, lease_ms=10_000, cookie=self.cookie, stream_key=has)
        self.origin, self.cookie, result = self.ask(request, signs=self.key_id is not None)
        if result != wire.SubscribeResult.OK:
            raise AssertionError(f"subscribed: {result}")

    def ask(self, request, signs=False):
        """(origin, cookie, result); with signs also the stream key."""
        if signs:
            self.counter += 1
            datagram = signed.sign_request(KEYS[self.key_id], self.key_id, self.origin, wire.PacketType.SUBSCRIBE, self.counter,
                                           request.pack())
        else:
            datagram = wire.seal(wire.Header(type=wire.PacketType.SUBSCRIBE), request.pack())
        self.socket.send(datagram)
        wanted = wire.PacketType.SIGNED_ANSWER if signs else wire.PacketType.SUBSCRIBED
        while True:
            answer = self.socket.recv(2048)
            header, payload = wire.parse(answer)
            if header.type != wanted:
                continue
            if signs:
                kind, counter, payload = signed.open_answer(KEYS[self.key_id], answer)
                if (kind, counter) != (wire.PacketType.SUBSCRIBED, self.counter):
                    raise AssertionError("an answer to something else")
                self.number, self.key = signed.open_stream_key(KEYS[self.key_id], self.key_id, header.origin, counter, payload)
            subscribed = wire.Subscribed.unpack(payload)
            return header.origin, subscribed.cookie, subscribed.result

    def datagrams(self, count):
        """Of the streams."""
        got = []
        while len(got) < count:
            datagram = self.socket.recv(2048)
            if wire.parse(datagram)[0].type < 128:
                got.append(datagram)
        return got


class SignedStream(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="stof_")
        self.addCleanup(folder.cleanup)
        self.port_file = pathlib.Path(folder.name, "port")
        self.sensor = subprocess.Popen(
            [*COMMAND, "--size", "64x48", "--pmd", "32x24", "--period-ms", "40", "--port", "0", "--port-file", self.port_file,
             "--keys", key_file(folder.name), "--set", "discovery.mdns=false", "--set", "discovery.beacon=false",
             "--set", "streams.parity=true"], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
        self.addCleanup(self.stop)
        deadline = time.monotonic() + 60
        while not (self.port_file.exists() and self.port_file.read_text().endswith("\n")):
            if time.monotonic() > deadline or self.sensor.poll() is not None:
                raise AssertionError("stofd did not start")
            time.sleep(0.02)
        self.port = int(self.port_file.read_text())

    def stop(self):
        os.kill(self.sensor.pid, signal.SIGTERM)
        self.sensor.communicate(timeout=60)

    def receiver(self, key_id=None):
        receiver = Receiver(self.port, key_id)
        self.addCleanup(receiver.close)
        return receiver

    def test_each_datagram_is_signed_for_its_receiver_alone(self):
        first, second, plain = self.receiver(7), self.receiver(8), self.receiver()
        self.assertNotEqual(first.key, second.key)
        got = first.datagrams(150)
        counters = [signed.signature(datagram)[1] for datagram in got]
        self.assertEqual(counters, list(range(counters[0], counters[0] + len(got))))
        self.assertEqual({signed.signature(datagram)[0] for datagram in got}, {first.number})
        kinds = {wire.parse(datagram)[0].type for datagram in got}
        self.assertLessEqual({wire.PacketType.TILE, wire.PacketType.FRAME_INFO, wire.PacketType.PARITY, wire.PacketType.CALIBRATION,
                              wire.PacketType.HEALTH}, kinds)
        for datagram in got:
            self.assertTrue(signed.signed_with(first.key, datagram))
            self.assertFalse(signed.signed_with(second.key, datagram))
        for datagram in second.datagrams(20):
            self.assertTrue(signed.signed_with(second.key, datagram))
        for datagram in plain.datagrams(20):
            self.assertIsNone(signed.signature(datagram))
            self.assertEqual(datagram[6], signed.HEADER)

    def test_a_renewed_lease_goes_on_and_a_new_key_counts_from_one(self):
        receiver = self.receiver(7)
        number, key = receiver.number, receiver.key
        highest = signed.signature(receiver.datagrams(30)[-1])[1]
        receiver.subscribe(has=number)
        self.assertEqual((receiver.number, receiver.key), (number, key))
        self.assertGreater(signed.signature(receiver.datagrams(1)[0])[1], highest)
        receiver.subscribe()
        self.assertGreater(receiver.number, number)
        of_new = [datagram for datagram in receiver.datagrams(60) if signed.signature(datagram)[0] == receiver.number]
        self.assertEqual(signed.signature(of_new[0])[1], 1)
        self.assertTrue(all(signed.signed_with(receiver.key, datagram) for datagram in of_new))


if __name__ == "__main__":
    at = sys.argv.index("--")
    COMMAND = sys.argv[at + 1:]
    unittest.main(argv=[sys.argv[0], *sys.argv[1:at]])
