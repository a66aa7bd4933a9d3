#!/usr/bin/env python3
"""A receiver in plain Python, written from docs/WIRE.md alone: a second opinion on the wire, as a stranger
would write it. It shares nothing with host/python/stof_wire.py, which is made of the table of messages, though both
have to say some of the same.

Subscribes to a sensor (--sensor), or listens at a port. Prints one line for each frame, with the CRC-32C of
its streams' pixels in raster order, and at the end what was refused, by cause.
"""

import argparse
import collections
import select
import socket
import struct
import sys
import time

from packets import (
    ANNOUNCE, CALIBRATION, CALIBRATION_BYTES, CRC_BYTES, EVENT, EVENT_PAYLOAD, FIRST_OWN_COUNTING,
    FRAME_INFO, FRAME_INFO_BYTES, HEADER, HEALTH, HEALTH_BYTES, PARITY, PARITY_FIELDS, RAW_INFO, RAW_TILE, Refused, SECTORS,
    STREAMS, SUBSCRIBE, SUBSCRIBED, SUBSCRIBED_PAYLOAD, SUBSCRIBE_PAYLOAD, TILE, UNSUBSCRIBE, ahead, crc32c,
    exclusive_or, groups_of, parse, pixels_of,
)
from lenses import Lenses
from raw_pictures import RawPictures

CONDITIONS = ("no frames, trigger lost, stereo lost, pmd lost, late, link lost, unreachable, link full, drift,"
              " serial lost, serial full, settings unsaved, restart needed, flooded,"
              " settings fell back, stereo silent, stereo frozen, pmd silent, pmd frozen, pmd dark,"
              " settings dropped, connection replaced, no depth, settings changed, unpaired, keys lost, pairing, keys changed, stereo blind,"
              " calibration changed, calibration dropped, release on trial").split(", ")
SEVERITIES = ("info", "minor", "major", "critical")
REACTIONS = ("none", "watch", "slow", "stop")
DEFAULT_PORT = 7560
LEASE_MS = 3000
SILENCE_S = 1.0
SESSION_SILENCE_S = 1.2
TELLING_OF_SENSOR = (TILE, FRAME_INFO, PARITY, CALIBRATION, HEALTH, EVENT)  # they begin a session and keep it
ASK_AGAIN_S = 0.2


class Frame:
    """One frame being put together. What does not arrive stays 0."""

    def __init__(self, header):
        self.header = header
        self.common = self.common_of(header)
        self.images = {}  # stream: (width, height, bytes)
        self.arrived = {}  # index: what parity is made of
        self.parity = {}  # group: the payload of its packet
        self.recovered = 0
        self.fingerprint = None  # of its calibration

    @staticmethod
    def common_of(header):
        return header.freshness, header.exposure, header.count

    def complete(self):
        return len(self.arrived) == self.header.count

    def add(self, header, payload):
        """Raises Refused."""
        if self.common_of(header) != self.common:
            raise Refused("field")
        if header.index in self.arrived:
            raise Refused("duplicate")
        known = True
        if header.type == TILE:
            known = header.stream in STREAMS and header.codec in STREAMS[header.stream][2]
            if known:
                self.place(header, pixels_of(header, payload))
        elif header.type == FRAME_INFO:
            if len(payload) < FRAME_INFO_BYTES:
                raise Refused("field")
            self.fingerprint = int.from_bytes(payload[240:244], "little")
        else:
            known = False
        self.arrived[header.index] = self.parity_part(header, payload)
        if not known:
            raise Refused("unknown")

    def place(self, header, pixels):
        width, height, image = self.images.setdefault(
            header.stream, (header.width, header.height, bytearray(header.width * header.height * STREAMS[header.stream][1])))
        if (width, height) != (header.width, header.height):
            raise Refused("field")
        size = STREAMS[header.stream][1]
        first = (header.first_row * width + header.first_column) * size
        image[first : first + len(pixels)] = pixels

    @staticmethod
    def parity_part(header, payload):
        fields = PARITY_FIELDS.pack(0, header.type, header.flags, header.stream, header.codec, header.width, header.height,
                                    header.first_row, header.first_column, header.pixel_count, len(payload))
        return fields + payload

    def add_parity(self, header, payload):
        """Raises Refused."""
        if len(payload) < PARITY_FIELDS.size:
            raise Refused("field")
        count = PARITY_FIELDS.unpack_from(payload)[0]
        if count != self.header.count or header.count != groups_of(count):
            raise Refused("field")
        self.parity[header.index] = bytes(2) + payload[2:]

    def recover(self):
        """Places what parity brings back. Raises Refused."""
        groups = groups_of(self.header.count)
        for group, parity in list(self.parity.items()):
            members = range(group, self.header.count, groups)
            missing = [index for index in members if index not in self.arrived]
            if len(missing) != 1:
                continue
            total = exclusive_or([parity, *(self.arrived[index] for index in members if index in self.arrived)])
            fields, data = total[: PARITY_FIELDS.size], total[PARITY_FIELDS.size :]
            _, kind, flags, stream, codec, width, height, row, column, pixels, length = PARITY_FIELDS.unpack(fields)
            del self.parity[group]
            if kind >= FIRST_OWN_COUNTING or any(data[length:]):
                raise Refused("field")
            header = self.header._replace(type=kind, flags=flags, stream=stream, codec=codec, width=width, height=height,
                                          first_row=row, first_column=column, pixel_count=pixels, payload_length=length,
                                          index=missing[0])
            self.add(header, data[:length])
            self.recovered += 1

    def line(self):
        crc = 0
        for stream in sorted(self.images):
            crc = crc32c(self.images[stream][2], crc)
        width, height = self.images[1][:2] if 1 in self.images else (self.header.width, self.header.height)
        recovered = f" recovered {self.recovered}" if self.recovered else ""
        return (
            f"frame {self.header.number} {width}x{height}"
            f" packets {len(self.arrived)}/{self.header.count}{recovered} crc {crc:08x}"
        )


class Receiver:
    """Datagrams in, closed frames out, in the order of their numbers."""

    def __init__(self):
        self.device = None
        self.session = None
        self.refused = collections.Counter()
        self.reports = []  # lines about health and events, to be taken by the caller
        self.exposures = []  # lines about raw pictures, likewise
        self.counts = collections.Counter()  # of packets taken, by type
        self.told = None  # device and session of the sensor's newest answer
        self.heard = 0.0
        self.begin_session(None)

    def begin_session(self, session):
        self.session = session
        self.lenses = Lenses()
        self.open = {}
        self.waiting = {}  # frame number: parity packets that came before any part
        self.last_closed = None
        self.freshness = None
        self.period = 0.0
        self.health = None  # (uptime, severity, reaction)
        self.event = None  # sequence of the newest
        self.last_packet = 0.0
        self.raw = RawPictures()

    def push(self, datagram, now=0.0):
        """The frames that this datagram closes."""
        try:
            header, payload = parse(datagram)
            if self.device is None:
                self.device = header.device
            if (header.device, header.session) != self.told if self.told else header.device != self.device:
                raise Refused("foreign")
            if header.type not in TELLING_OF_SENSOR:
                if header.session != self.session:
                    raise Refused("unknown" if self.session is None else "foreign")
            elif header.session != self.session:
                if self.session is not None and self.told is None and now - self.heard < SESSION_SILENCE_S:
                    raise Refused("foreign")
                self.begin_session(header.session)
            if header.type in TELLING_OF_SENSOR:
                self.heard = now
            if header.type < FIRST_OWN_COUNTING:
                closed = self.push_part(header, payload)
                self.last_packet = now
                return closed
            if header.type == PARITY:
                return self.push_parity(header, payload)
            self.push_other(header, payload, now)
            self.counts[header.type] += 1
        except Refused as cause:
            self.refused[str(cause)] += 1
        return []

    def push_other(self, header, payload, now):
        if header.type == CALIBRATION:
            if len(payload) < CALIBRATION_BYTES:
                raise Refused("field")
            if not self.lenses.take(payload, now):
                raise Refused("contradiction")
            self.period = struct.unpack_from("<q", payload, 48)[0] / 1e9
        elif header.type == HEALTH:
            self.push_health(payload)
        elif header.type == EVENT:
            self.push_event(payload)
        elif header.type in (RAW_INFO, RAW_TILE):
            self.exposures += self.raw.push(header, payload)
        elif header.type not in (ANNOUNCE, SECTORS):
            raise Refused("unknown")

    def push_health(self, payload):
        if len(payload) < HEALTH_BYTES:
            raise Refused("field")
        uptime, active, severity, reaction, subscribers, rate = struct.unpack_from("<QIBBBxI", payload)
        if self.health is not None and uptime < self.health[0]:
            raise Refused("late")
        self.health = uptime, severity, reaction
        names = ", ".join(name for bit, name in enumerate(CONDITIONS) if active >> bit & 1) or "nothing wrong"
        self.reports.append(f"health {name_in(SEVERITIES, severity)} robot {name_in(REACTIONS, reaction)} subscribers"
                            f" {subscribers} rate {rate / 1000:.1f} Hz: {names}")

    def push_event(self, payload):
        if len(payload) < EVENT_PAYLOAD.size:
            raise Refused("field")
        sequence, condition, severity, reaction, active, count, value, _, _ = EVENT_PAYLOAD.unpack_from(payload)
        if self.event is not None and ahead(sequence, self.event) <= 0:
            return  # the repetition
        self.event = sequence
        self.reports.append(f"event {name_in(CONDITIONS, condition)} {'began' if active else 'ended'}"
                            f" {name_in(SEVERITIES, severity)} robot {name_in(REACTIONS, reaction)} count {count} value {value}")

    def push_part(self, header, payload):
        number = header.number
        if self.last_closed is not None and ahead(number, self.last_closed) <= 0:
            raise Refused("late")
        if any(ahead(other, number) >= 2 for other in self.open):
            raise Refused("late")
        closed = self.close(lambda other: ahead(number, other) >= 2)
        if number not in self.open:
            self.open[number] = Frame(header)
            for waiting in self.waiting.pop(number, ()):
                self.try_to(lambda packet=waiting: self.open[number].add_parity(*packet))
        frame = self.open[number]
        self.try_to(lambda: frame.add(header, payload))
        self.counts[header.type] += 1
        return closed + self.finish(frame)

    def push_parity(self, header, payload):
        self.counts[PARITY] += 1
        number = header.number
        if number in self.open:
            frame = self.open[number]
            frame.add_parity(header, payload)
            return self.finish(frame)
        if self.last_closed is None or ahead(number, self.last_closed) > 0:
            self.waiting.setdefault(number, []).append((header, payload))
        return []

    def finish(self, frame):
        self.try_to(frame.recover)
        if frame.complete():
            return self.close(lambda other: ahead(frame.header.number, other) >= 0)
        return []

    def try_to(self, action):
        try:
            action()
        except Refused as cause:
            self.refused[str(cause)] += 1

    def expire(self, now):
        """The frames that nothing came for."""
        if self.open and now - self.last_packet > max(0.1, 1.5 * self.period):
            return self.close(lambda other: True)
        return []

    def close(self, condition):
        closed = []
        oldest_first = sorted(self.open, key=lambda n: min(ahead(n, m) for m in self.open))
        for number in oldest_first:
            if condition(number):
                frame = self.open.pop(number)
                self.last_closed = number
                self.waiting = {n: parts for n, parts in self.waiting.items() if ahead(n, number) > 0}
                fresh = frame.header.freshness
                if ahead(fresh, self.freshness) > 0 if self.freshness is not None else fresh != 0:
                    self.freshness = fresh
                    if frame.fingerprint is not None:
                        self.lenses.note_frame(frame.fingerprint, *frame.images.get(1, (0, 0))[:2], self.last_packet)
                    closed.append(frame)
                else:
                    self.refused["stale frame"] += 1
        return closed


def name_in(names, value):
    return names[value] if value < len(names) else str(value)


class Subscription:
    """What to send to a sensor and when. No clock and no socket: `now` in seconds is the caller's."""

    def __init__(self, now, raw=0, every=1):
        self.raw = raw, every
        self.cookie = 0
        self.origin = None  # device and session of the sensor, by its newest answer
        self.request = 0
        self.granted = 0.0  # seconds; 0: none
        self.next_at = now
        self.heard_at = now

    def due(self, now):
        """The datagram to send, or None."""
        if self.granted and now - self.heard_at > SILENCE_S:
            self.granted, self.cookie = 0.0, 0  # the sensor has started again, or the network is back
            self.next_at = now
        if now < self.next_at:
            return None
        self.request += 1
        self.next_at = now + (self.granted / 3 if self.granted else ASK_AGAIN_S)
        return self.packet(SUBSCRIBE)

    def packet(self, kind):
        pictures, every = self.raw
        payload = SUBSCRIBE_PAYLOAD.pack(self.request, LEASE_MS, 0, self.cookie, pictures, 0, every)
        header = HEADER.pack(b"STOF", 1, kind, HEADER.size, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, len(payload))
        return header + payload + crc32c(header + payload).to_bytes(CRC_BYTES, "little")

    def heard(self, datagram, now):
        """Whether this is an answer to us; the datagram is any that came from the sensor."""
        self.heard_at = now
        if len(datagram) < HEADER.size or datagram[5] != SUBSCRIBED:
            return False
        try:
            header, payload = parse(datagram)
        except Refused:
            return False
        if len(payload) < SUBSCRIBED_PAYLOAD.size:
            return False
        request, result, _, lease_ms, cookie = SUBSCRIBED_PAYLOAD.unpack_from(payload)
        if request != self.request:
            return True
        self.cookie, self.origin = cookie, (header.device, header.session)
        if result == 1:  # cookie
            self.next_at = now
        elif result in (0, 6, 7):  # ok; without raw pictures
            self.granted = lease_ms / 1000
            self.next_at = now + self.granted / 3
        else:
            self.granted = 0.0
        return True


def sensor_address(text):
    host, colon, port = text.rpartition(":")
    return (host, int(port)) if colon else (text, DEFAULT_PORT)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sensor", metavar="HOST[:PORT]", help="subscribe there")
    parser.add_argument("--address", default="0.0.0.0")
    parser.add_argument("--port", type=int, help=f"listen here; 0: any free one, printed; {DEFAULT_PORT} without --sensor")
    parser.add_argument("--frames", type=int, default=0, help="stop after so many; 0: never")
    parser.add_argument("--seconds", type=float, default=0, help="stop after so long; 0: never")
    parser.add_argument("--raw", type=int, default=0, help="raw pictures to ask for: 1 left, 2 right, 4 PMD camera, 8 only all of them; printed by exposure")
    parser.add_argument("--raw-every", type=int, default=1, help="of one frame of so many")
    parser.add_argument("--reports", action="store_true", help="print health and events too")
    options = parser.parse_args()
    endpoint = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    endpoint.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
    port = options.port if options.port is not None else 0 if options.sensor else DEFAULT_PORT
    endpoint.bind((options.address, port))
    print(f"listening {endpoint.getsockname()[1]}", flush=True)
    sensor = sensor_address(options.sensor) if options.sensor else None
    receiver = Receiver()
    begin = time.monotonic()
    subscription = Subscription(begin, options.raw, options.raw_every) if sensor else None
    frames = 0
    while options.frames == 0 or frames < options.frames:
        now = time.monotonic()
        if options.seconds and now - begin > options.seconds:
            break
        request = subscription.due(now) if subscription else None
        if request:
            endpoint.sendto(request, sensor)
        closed = []
        if select.select([endpoint], [], [], 0.05)[0]:
            try:
                datagram = endpoint.recv(65536)
            except ConnectionError:
                continue  # nobody listens there yet
            now = time.monotonic()
            if subscription and subscription.heard(datagram, now):
                receiver.told = subscription.origin
            else:
                closed = receiver.push(datagram, now)
        else:
            closed = receiver.expire(now)
        for frame in closed:
            print(frame.line(), flush=True)
            frames += 1
        if options.reports and receiver.reports:
            print("\n".join(receiver.reports), flush=True)
        receiver.reports.clear()
        if receiver.exposures:
            print("\n".join(receiver.exposures), flush=True)
        receiver.exposures.clear()
    if subscription:
        endpoint.sendto(subscription.packet(UNSUBSCRIBE), sensor)
    for line in receiver.raw.end():
        print(line, flush=True)
    refused = " ".join(f"{cause} {count}" for cause, count in sorted(receiver.refused.items()))
    print(f"refused {refused}", flush=True)
    taken = " ".join(f"{kind} {count}" for kind, count in sorted(receiver.counts.items()))
    print(f"taken by type {taken}", flush=True)
    return 0 if options.frames <= frames else 1


if __name__ == "__main__":
    sys.exit(main())
