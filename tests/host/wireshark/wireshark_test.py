#!/usr/bin/env python3
"""host/wireshark/stof.lua in tshark: every packet is read, a damaged one is reported. Skipped (77) without tshark."""

import dataclasses
import json
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "host/python"))
import stof_wire as wire  # noqa: E402

SCRIPT = ROOT / "host/wireshark/stof.lua"


def ethernet(datagram, port, number):
    """An Ethernet frame with an IPv4 packet with a UDP datagram."""
    udp = struct.pack(">HHHH", 40000, port, 8 + len(datagram), 0) + datagram
    ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), number, 0, 64, 17, 0, bytes([10, 0, 0, 1]),
                     bytes([10, 0, 0, 2]))
    return bytes(12) + b"\x08\x00" + ip + udp


def write_pcap(file, datagrams, port):
    with file.open("wb") as out:
        out.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1))
        for number, datagram in enumerate(datagrams):
            frame = ethernet(datagram, port, number)
            out.write(struct.pack("<IIII", 1000 + number, 0, len(frame), len(frame)) + frame)


def leaves(tree):
    """{field: value} of a tree of trees."""
    found = {}
    for name, value in tree.items():
        found |= leaves(value) if isinstance(value, dict) else {name: value}
    return found


class Wireshark(unittest.TestCase):
    def dissect(self, datagrams, port=7560):
        """The list of {field: [values]}, one for each packet."""
        with tempfile.TemporaryDirectory(prefix="stof_") as folder:
            pcap = pathlib.Path(folder, "packets.pcap")
            write_pcap(pcap, datagrams, port)
            done = subprocess.run(["tshark", "-r", pcap, "-X", f"lua_script:{SCRIPT}", "-T", "ek"],
                                  capture_output=True, text=True, timeout=120, env={"HOME": folder, "PATH": "/usr/bin"})
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertNotIn("Lua", done.stderr)
        packets = [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"timestamp')]
        self.assertEqual(len(packets), len(datagrams))
        return [packet["layers"] for packet in packets]

    def one(self, datagram, **options):
        return self.dissect([datagram], **options)[0]

    def test_every_message_is_read_field_by_field(self):
        kinds = list(wire.MESSAGES.items())
        values = [message.unpack(bytes(i % 251 for i in range(message.size()))) for _, message in kinds]
        packets = [wire.seal(wire.Header(type=kind, number=77, count=1), value.pack())
                   for (kind, _), value in zip(kinds, values)]
        for (kind, _), value, layers in zip(kinds, values, self.dissect(packets)):
            with self.subTest(kind.name):
                seen = leaves(layers["stof"])
                self.assertEqual(seen["stof_stof_number"], "77")
                self.assertEqual(seen["stof_stof_crc_good"], True)
                self.assertNotIn("_ws_expert", json.dumps(layers))
                message = {"UNSUBSCRIBE": "subscribe", "SIGNED_REQUEST": "signed_fields", "SIGNED_ANSWER": "signed_fields"}.get(kind.name, kind.name.lower())
                for field in dataclasses.fields(value):
                    at = f"stof_stof_{message}_{field.name}"
                    number = getattr(value, field.name)
                    if isinstance(number, int):
                        self.assertEqual(int(seen[at], 0), number, at)
                    elif isinstance(number, tuple) and isinstance(number[0], int):
                        found = seen[at] if isinstance(seen[at], list) else [seen[at]]
                        self.assertEqual([int(one, 0) for one in found], list(number), at)

    def test_a_tile_shows_its_payload(self):
        seen = self.one(wire.seal(wire.Header(type=wire.PacketType.TILE, number=9, index=2, count=5), b"ab"))
        self.assertIn("stof_stof_payload", leaves(seen["stof"]))

    def test_a_wrong_crc_is_reported(self):
        good = wire.seal(wire.Header(type=wire.PacketType.HEALTH), wire.HealthReport().pack())
        seen = self.one(good[:60] + bytes([good[60] ^ 4]) + good[61:])
        self.assertEqual(leaves(seen)["stof_stof_crc_good"], False)
        self.assertIn("wrong CRC-32C", json.dumps(seen))

    def test_what_is_cut_short_is_reported(self):
        good = wire.seal(wire.Header(type=wire.PacketType.HEALTH), wire.HealthReport().pack())
        for size in (4, 20, 55, 56, len(good) - 1):
            self.assertIn("shorter than it says", json.dumps(self.one(good[:size])), size)

    def test_other_ports_are_recognised_by_the_magic(self):
        good = wire.seal(wire.Header(type=wire.PacketType.DISCOVER), wire.Discover(request_id=5).pack())
        self.assertIn("stof", self.one(good, port=41000))
        self.assertNotIn("stof", self.one(bytes(200), port=41000))


if __name__ == "__main__":
    if not shutil.which("tshark"):
        print("Wireshark: Skipped\ntshark is not installed")
        sys.exit(77)
    unittest.main()
