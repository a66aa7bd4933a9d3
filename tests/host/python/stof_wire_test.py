#!/usr/bin/env python3
"""host/python/stof_wire.py by itself: packets that are sealed are parsed, whatever else is refused."""

import dataclasses
import pathlib
import random
import struct
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "host/python"))
import stof_wire as wire  # noqa: E402


def filled(kind, randomness):
    """An object of a message class with random numbers in every field."""
    return kind.unpack(bytes(randomness.randrange(256) for _ in range(kind.size())))


class StofWire(unittest.TestCase):
    def setUp(self):
        self.random = random.Random(5)

    def packet(self, payload=b"payload", **fields):
        fields = {"type": wire.PacketType.TILE, "index": 1, "count": 3, **fields}
        return wire.seal(wire.Header(**fields), payload)

    def refused(self, datagram):
        with self.assertRaises(wire.Refused) as caught:
            wire.parse(datagram)
        return str(caught.exception)

    def test_crc_is_that_of_the_catalogue(self):
        self.assertEqual(wire.crc32c(b"123456789"), 0xE3069283)
        self.assertEqual(wire.crc32c(b"56789", wire.crc32c(b"1234")), 0xE3069283)
        self.assertEqual(wire.crc32c(b""), 0)

    def test_every_message_survives_being_packed(self):
        for kind, message in wire.MESSAGES.items():
            with self.subTest(kind.name):
                value = filled(message, self.random)
                texts = [field.name for field in dataclasses.fields(message) if field.type is str]
                value = dataclasses.replace(value, **{name: "Grüße" for name in texts})
                header, payload = wire.parse(self.packet(value.pack() + b"tail", type=kind))
                self.assertEqual(header.type, kind)
                self.assertEqual(len(payload), message.size() + 4)
                self.assertEqual(message.unpack(payload), value)

    def test_frame_info_says_on_how_many_frames_a_depth_stands(self):
        payload = wire.FrameInfo(steady_frames=1234).pack()
        self.assertEqual(struct.unpack_from("<I", payload, 232), (1234,))  # as docs/WIRE.md has it
        self.assertEqual(wire.FrameInfo.unpack(payload).steady_frames, 1234)

    def test_the_header_survives_being_sealed(self):
        header = dataclasses.replace(filled(wire.Header, self.random), magic=wire.Header.magic, version=1, index=6,
                                     count=7, header_length=52, payload_length=3)
        self.assertEqual(wire.parse(wire.seal(header, b"abc")), (header, b"abc"))

    def test_less_than_a_message_is_refused(self):
        for message in wire.MESSAGES.values():
            with self.assertRaises(wire.Refused):
                message.unpack(bytes(message.size() - 1))

    def test_refuses_in_the_order_of_the_document(self):
        good = self.packet()
        self.assertEqual(self.refused(good[:-1]), "truncated")
        self.assertEqual(self.refused(b""), "truncated")
        self.assertEqual(self.refused(b"X" + good[1:]), "magic")
        self.assertEqual(self.refused(good[:4] + b"\x02" + good[5:]), "version")
        self.assertEqual(self.refused(good[:6] + b"\x33" + good[7:]), "length")
        self.assertEqual(self.refused(good + b"\0"), "length")
        self.assertEqual(self.refused(good[:-1] + bytes([good[-1] ^ 1])), "crc")
        self.assertEqual(self.refused(self.packet(index=3)), "field")

    def test_no_bit_may_flip(self):
        good = self.packet()
        for bit in range(8 * len(good)):
            damaged = bytearray(good)
            damaged[bit // 8] ^= 1 << bit % 8
            self.refused(bytes(damaged))

    def test_skips_a_longer_header(self):
        packet = bytearray(self.packet()[:-4])
        packet[6] = 56
        packet[52:52] = b"new!"
        packet += wire.crc32c(packet).to_bytes(4, "little")
        self.assertEqual(wire.parse(packet)[1], b"payload")

    def test_a_signature_is_read_where_there_is_one(self):
        page = (pathlib.Path(__file__).resolve().parents[3] / "docs/WIRE.md").read_text(encoding="utf-8")
        plain, signed = (bytes.fromhex(page.split(heading, 1)[1].split("```hex\n", 1)[1].split("```", 1)[0])
                         for heading in ("\n## A worked packet\n", "\n## The same packet, signed\n"))
        self.assertEqual(wire.parse(signed)[1], wire.parse(plain)[1])
        self.assertIsNone(wire.signature(plain))
        found = wire.signature(signed)
        self.assertEqual((found.number, found.counter, bytes(found.tag)), (1, 39, signed[64:80]))

    def test_what_does_not_fit_is_told(self):
        with self.assertRaises(ValueError):
            self.packet(bytes(1177))
        self.assertEqual(len(self.packet(bytes(1176))), wire.MAX_DATAGRAM)
        with self.assertRaises(struct.error):
            wire.Discover(request_id=1 << 32).pack()
        with self.assertRaises(struct.error):
            wire.FrameInfo(tiles=(1, 2)).pack()

    def test_every_condition_is_explained(self):
        self.assertEqual(list(wire.CONDITIONS), list(wire.Condition))


if __name__ == "__main__":
    unittest.main()
