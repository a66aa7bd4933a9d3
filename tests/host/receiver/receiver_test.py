#!/usr/bin/env python3
"""tests/host/receiver/receiver.py on packets that Python makes: every codec, parity, reports, subscription."""

import itertools
import pathlib
import random
import struct
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests/host/receiver"), str(ROOT / "scripts")]
import lenses  # noqa: E402
import packets  # noqa: E402
import receiver  # noqa: E402
from wire import samples  # noqa: E402

wire = samples.wire


def with_parity(parts):
    """The frame's datagrams and the parity packets of docs/WIRE.md behind them."""
    parsed = [wire.parse(part) for part in parts]
    groups = (len(parts) + 15) // 16
    found = list(parts)
    for group in range(groups):
        total = bytearray(wire.ParityFields.size() + max(len(payload) for _, payload in parsed[group::groups]))
        for header, payload in parsed[group::groups]:
            fields = wire.ParityFields(0, header.type, header.flags, header.stream, header.codec, header.image_width,
                                       header.image_height, header.first_row, header.first_column, header.pixel_count,
                                       len(payload)).pack()
            for i, byte in enumerate(fields + payload):
                total[i] ^= byte
        total[0:2] = len(parts).to_bytes(2, "little")
        found.append(samples.seal(wire.PacketType.PARITY, bytes(total), index=group, count=groups, image_width=4,
                                  image_height=2))
    return found


def long_frame(rows=40):
    """A frame of a tile for each row of 4 pixels, with as many parts as rows and one more."""
    info = samples.seal(wire.PacketType.FRAME_INFO, wire.FrameInfo(tiles=(rows, 0, 0, 0, 0, 0, 0, 0)).pack(),
                        count=rows + 1, image_width=4, image_height=rows)
    return [info] + [samples.tile(1, 3, samples.rvl([y, 0, y + 1, 65535 - y], 16), y + 1, rows + 1, image_height=rows,
                                  first_row=y, pixel_count=4) for y in range(rows)]


def renumbered(parts, number):
    """The same frame with another number and freshness."""
    found = []
    for part in parts:
        header, payload = wire.parse(part)
        header.number, header.freshness = number & 0xFFFFFFFF, number + 1 & 0xFFFFFFFF
        found.append(wire.seal(header, payload))
    return found


class ReceiverTest(unittest.TestCase):
    def lines(self, datagrams, taker=None):
        taker = taker or receiver.Receiver()
        return [frame.line() for datagram in datagrams for frame in taker.push(datagram)]

    def test_the_documents_frame_arrives_raw_and_coded(self):
        raw, coded = self.lines(samples.frame(False)), self.lines(samples.frame(True))
        self.assertEqual(len(raw), 1)
        self.assertEqual(raw, coded)
        self.assertIn("frame 7 4x2 packets 4/4 crc", raw[0])

    def test_every_stream_of_every_codec_is_placed(self):
        kinds = [(stream, codec) for stream, (_, _, codecs) in packets.STREAMS.items() for codec in codecs]
        for stream, codec in kinds:
            with self.subTest(stream=stream, codec=codec):
                size = packets.STREAMS[stream][1]
                pixels = bytes(random.Random(stream).randrange(256) for _ in range(8 * size))
                payload = pixels
                if codec in (packets.RVL16, packets.RVL8):
                    payload = samples.rvl(struct.unpack(f"<8{'H' if size == 2 else 'B'}", pixels), 8 * size)
                frames = receiver.Receiver().push(samples.tile(stream, codec, payload, 0, 1))
                self.assertEqual(bytes(frames[0].images[stream][2]), pixels)

    def test_depth_and_width_have_a_scale_and_nothing_else_has(self):
        for stream, (_, size, codecs) in packets.STREAMS.items():
            for codec in codecs:
                with self.subTest(stream=stream, codec=codec):
                    values = [0, 1, 2, 3, 0, 100, 2047, 7] if size == 2 else [1] * 8
                    payload = struct.pack("<8H", *values) if size == 2 else bytes(8 * size)
                    if codec in (packets.RVL16, packets.RVL8):
                        payload = samples.rvl(values, 8 * size)
                    taker = receiver.Receiver()
                    frames = taker.push(samples.tile(stream, codec, payload, 0, 1, flags=0xA5))
                    if stream in (1, 2):
                        expected = struct.pack("<8H", *(32 * value for value in values))
                        self.assertEqual(bytes(frames[0].images[stream][2]), expected)
                    else:
                        self.assertEqual((frames, taker.refused), ([], {"field": 1}))
        for flags, refused in ((5, {}), (6, {"field": 1})):
            taker = receiver.Receiver()
            taker.push(samples.tile(1, 1, struct.pack("<8H", *[1023] * 7, 1024), 0, 1, flags=flags))
            self.assertEqual(taker.refused, refused)

    def test_the_documents_decoder_agrees(self):
        text = (ROOT / "docs/WIRE.md").read_text(encoding="utf-8")
        names = {"struct": struct}
        exec(text.split("```python\n")[1].split("```")[0], names)  # the document's own function
        chance = random.Random(3)
        for bits in (8, 16):
            for _ in range(300):
                values = [chance.choice((0, 0, 1, 100, chance.randrange(1 << bits))) for _ in range(chance.randrange(1, 60))]
                coded = samples.rvl(values, bits)
                self.assertEqual(names["rvl"](coded, len(values), bits), values)
                packed = struct.pack(f"<{len(values)}{'H' if bits == 16 else 'B'}", *values)
                self.assertEqual(packets.rvl(coded, len(values), bits // 8), packed)

    def test_rvl_that_is_not_the_code_of_the_tile_is_refused(self):
        good = samples.rvl(samples.DEPTH, 16)
        hostile = {"short": good[:-4], "long": good + bytes(4), "odd": good[:-1], "empty": b"",
                   "without end": b"\xff" * 12, "run too long": samples.rvl([0] * 9, 16),
                   "two empty runs": struct.pack("<I", 0x00080000), "no fill": struct.pack("<I", 0x80000001)}
        for what, payload in hostile.items():
            with self.subTest(what), self.assertRaises(packets.Refused):
                packets.rvl(payload, 8, 2)

    def test_each_lost_packet_comes_back_from_parity(self):
        parts = with_parity(long_frame())
        self.assertEqual(len(parts), 41 + 3)
        whole = self.lines(parts[:41])
        for lost in range(41):
            seen = self.lines(parts[:lost] + parts[lost + 1:])
            self.assertEqual(seen, [whole[0].replace("41/41", "41/41 recovered 1")], lost)

    def test_a_burst_of_three_comes_back(self):
        parts = with_parity(long_frame())
        self.assertIn("recovered 3", self.lines(parts[:20] + parts[23:])[0])

    def test_parity_may_come_first_and_in_any_order(self):
        parts = with_parity(long_frame())[1:]
        random.Random(2).shuffle(parts)
        self.assertIn("packets 41/41", self.lines(parts)[0])
        self.assertIn("packets 41/41", self.lines(reversed(with_parity(long_frame())[1:]))[0])

    def test_two_lost_of_one_group_stay_lost(self):
        taker = receiver.Receiver()
        parts = with_parity(long_frame())
        self.assertEqual(self.lines(parts[:3] + parts[4:6] + parts[7:], taker), [])
        self.assertIn("packets 39/41", taker.expire(10.0)[0].line())

    def test_a_thousand_frames_and_messages_without_an_error(self):
        taker = receiver.Receiver()
        frame, others = samples.frame(True), [p for name, p in samples.messages().items() if name in ("calibration", "health")]
        frames = 0
        for number in range(0xFFFFFE00, 0xFFFFFE00 + 1000):
            packets = renumbered(frame, number) + (others if number % 10 == 0 else [])
            frames += len(self.lines(packets, taker))
        self.assertEqual(frames, 1000)
        self.assertEqual(taker.refused, {})

    def test_reports_are_told_once(self):
        taker = receiver.Receiver()
        event = wire.EventReport(sequence=5, condition=wire.Condition.LINK_FULL, severity=2, reaction=2, active=1, count=3, value=9)
        for _ in range(2):
            taker.push(samples.seal(wire.PacketType.EVENT, event.pack()))
        health = wire.HealthReport(uptime_ms=10, active=1 << 7, severity=2, reaction=2, subscribers=1, rate_millihertz=29970)
        taker.push(samples.seal(wire.PacketType.HEALTH, health.pack()))
        health.uptime_ms = 9
        taker.push(samples.seal(wire.PacketType.HEALTH, health.pack()))
        self.assertEqual(taker.reports, ["event link full began major robot slow count 3 value 9",
                                         "health major robot slow subscribers 1 rate 30.0 Hz: link full"])
        self.assertEqual(taker.refused, {"late": 1})

    def test_names_and_sizes_are_those_of_the_table(self):
        self.assertEqual(receiver.CONDITIONS, [c.name.lower().replace("_", " ") for c in wire.Condition])
        for name, message in (("FRAME_INFO", wire.FrameInfo), ("CALIBRATION", wire.CalibrationPacket), ("HEALTH", wire.HealthReport)):
            self.assertEqual(getattr(receiver, f"{name}_BYTES"), message.size())

    def test_unknown_types_are_no_error_and_damage_is_refused(self):
        taker = receiver.Receiver()
        taker.push(samples.seal(99, b"new"))
        self.assertEqual(taker.refused, {"unknown": 1})
        for bit in range(0, 8 * 68, 7):
            damaged = bytearray(samples.frame(True)[1])
            damaged[bit // 8] ^= 1 << bit % 8
            taker.push(bytes(damaged))
        self.assertEqual(taker.open, {})


class SessionTest(unittest.TestCase):
    def setUp(self):
        self.receiver = receiver.Receiver()

    def hear(self, session, now):
        """The session that is listened to then."""
        origin = wire.Origin(device_id=1, session_id=session)
        self.receiver.push(wire.seal(wire.Header(type=wire.PacketType.HEALTH, origin=origin), wire.HealthReport().pack()), now)
        return self.receiver.session

    def test_another_one_begins_where_the_one_before_is_silent(self):
        heard = [self.hear(session, now) for session, now in ((1, 5.0), (2, 6.0), (1, 6.1), (2, 7.2), (2, 7.4), (1, 8.0), (1, 9.0))]
        self.assertEqual(heard, [1, 1, 1, 1, 2, 2, 1])

    def test_who_asked_takes_the_one_that_answered(self):
        self.receiver.told = 1, 2
        self.assertEqual([self.hear(1, 5.0), self.hear(2, 5.1), self.hear(1, 99.0)], [None, 2, 2])
        self.receiver.told = 1, 1
        self.assertEqual([self.hear(2, 99.1), self.hear(1, 99.2)], [2, 1])


class LensesTest(unittest.TestCase):
    TRUE, FORGED = 111, 444

    def setUp(self):
        self.lenses, self.now = lenses.Lenses(), 100.0

    def say(self, fx, fingerprint=7, image_width=4, **fields):
        told = wire.CalibrationPacket(image_width=image_width, image_height=2, fx=fx, fy=1, fingerprint=fingerprint, **fields)
        return self.lenses.take(told.pack(), self.now)

    def stream(self, seconds, lie=lambda: None, fingerprint=7):
        """The lenses that ten frames a second have, with the true one once a second."""
        found = []
        for k in range(seconds * 10):
            self.now += 0.1
            if k % 10 == 0:
                self.say(self.TRUE, fingerprint)
            self.lenses.note_frame(fingerprint, 4, 2, self.now)
            lens = self.lenses.of(fingerprint, 4, 2)
            found.append(wire.CalibrationPacket.unpack(lens).fx if lens else None)
            lie()
        return set(found)

    def test_one_that_contradicts_the_known_one_is_not_believed_at_any_rate(self):
        self.assertEqual(self.stream(5), {self.TRUE})
        self.assertEqual(self.stream(30, lambda: self.say(self.FORGED)), {self.TRUE})
        self.assertEqual(self.stream(30, lambda: self.say(int(self.now * 10))), {self.TRUE})
        self.assertEqual(self.stream(30, lambda: self.say(self.TRUE, depth_unit_um=1000)), {self.TRUE})
        self.assertEqual(self.stream(30, lambda: self.say(self.FORGED, fingerprint=int(self.now * 10))), {self.TRUE})

    def test_other_sizes_push_none_out_that_stands(self):
        def lie():
            for width in range(10, 42):
                self.say(self.FORGED, image_width=width)
            self.say(self.FORGED)
        self.assertEqual(self.stream(5), {self.TRUE})
        self.assertEqual(self.stream(10, lie), {self.TRUE})

    def test_from_the_start_neither_is_believed_and_the_true_one_when_it_is_alone(self):
        self.say(self.FORGED)
        self.assertEqual(self.stream(30, lambda: self.say(self.FORGED)), {None})
        self.assertEqual(self.stream(6), {None, self.TRUE})
        self.assertEqual(self.stream(11), {self.TRUE})
        self.assertEqual(self.stream(30, lambda: self.say(self.FORGED)), {self.TRUE})

    def test_settings_change_range_and_period_and_another_fingerprint_the_lens(self):
        self.stream(5)
        self.assertTrue(self.say(self.TRUE, max_range=5, period_ns=7))
        self.assertTrue(self.say(222, fingerprint=8))
        self.lenses.note_frame(8, 4, 2, self.now)
        self.assertIsNotNone(self.lenses.of(8, 4, 2))

    def test_one_that_is_gone_for_ten_seconds_gives_way(self):
        self.stream(5)
        found = []
        for _ in range(120):
            self.now += 0.1
            self.lenses.note_frame(7, 4, 2, self.now)
            found.append(self.say(222))
        self.assertEqual((found[0], found[90], found[-1]), (False, False, True))


class SubscriptionTest(unittest.TestCase):
    def answer(self, request, **fields):
        header, payload = wire.parse(request)
        asked = wire.Subscribe.unpack(payload)
        self.assertEqual(header.type, wire.PacketType.SUBSCRIBE)
        fields = {"request_id": asked.request_id, "lease_ms": 3000, "cookie": 77, **fields}
        return asked, samples.seal(wire.PacketType.SUBSCRIBED, wire.Subscribed(**fields).pack())

    def test_cookie_first_then_a_lease_that_is_kept_alive(self):
        subscription = receiver.Subscription(0.0)
        asked, answer = self.answer(subscription.due(0.0), result=wire.SubscribeResult.COOKIE)
        self.assertEqual(asked.cookie, 0)
        self.assertTrue(subscription.heard(answer, 0.01))
        asked, answer = self.answer(subscription.due(0.01), result=wire.SubscribeResult.OK)
        self.assertEqual(asked.cookie, 77)
        self.assertTrue(subscription.heard(answer, 0.02))
        sent = []
        for tick in itertools.takewhile(lambda t: t < 60, itertools.count(2)):
            now = tick * 0.05
            subscription.heard(samples.frame(False)[0], now)
            request = subscription.due(now)
            if request:
                sent.append(now)
                subscription.heard(self.answer(request, result=wire.SubscribeResult.OK)[1], now)
        self.assertEqual(len(sent), 2)  # once a second
        self.assertFalse(subscription.heard(samples.frame(False)[0], 3.0))

    def test_asks_again_and_begins_anew_after_silence(self):
        subscription = receiver.Subscription(0.0)
        self.assertIsNotNone(subscription.due(0.0))
        self.assertIsNone(subscription.due(0.1))
        _, answer = self.answer(subscription.due(0.2), result=wire.SubscribeResult.OK)
        subscription.heard(answer, 0.2)
        self.assertIsNone(subscription.due(1.1))
        asked, _ = self.answer(subscription.due(1.3))
        self.assertEqual(asked.cookie, 0)


if __name__ == "__main__":
    unittest.main()
