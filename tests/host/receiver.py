#!/usr/bin/env python3
"""A receiver in plain Python, written from docs/WIRE.md alone: a second opinion on the wire.

Prints one line for each frame, with the CRC-32C of its depth, width and source pixels in raster
order, and at the end what was refused, by cause.
"""

import argparse
import collections
import socket
import struct

HEADER = struct.Struct("<4sBBBBIIBBBBIqIHHHHHHHH")  # without the payload and the CRC
CRC_BYTES = 4
MAX_DATAGRAM = 1232
TILE, FRAME_INFO, CALIBRATION = 1, 2, 64
FIRST_OWN_COUNTING = 64
FRAME_INFO_BYTES = 120
# (stream, codec): name, bytes of a pixel
KINDS = {(1, 1): ("depth", 2), (2, 1): ("width", 2), (3, 2): ("source", 1)}

Header = collections.namedtuple(
    "Header",
    "magic version type header_length flags device session stream codec health clock number"
    " exposure freshness index count width height first_row first_column pixel_count"
    " payload_length",
)


def make_crc_table():
    table = []
    for byte in range(256):
        crc = byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x82F63B78 if crc & 1 else 0)
        table.append(crc)
    return table


CRC_TABLE = make_crc_table()


def crc32c(data, before=0):
    crc = before ^ 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


assert crc32c(b"123456789") == 0xE3069283


def ahead(a, b):
    """How far a is ahead of b where both wrap at 2^32; negative when behind."""
    distance = (a - b) & 0xFFFFFFFF
    return distance if distance < 1 << 31 else distance - (1 << 32)


class Refused(Exception):
    """A datagram that is not taken; its text is the cause."""


def parse(datagram):
    """Header and payload of a verified packet; raises Refused."""
    if len(datagram) < HEADER.size + CRC_BYTES:
        raise Refused("truncated")
    header = Header(*HEADER.unpack_from(datagram))
    if header.magic != b"STOF":
        raise Refused("magic")
    if header.version != 1:
        raise Refused("version")
    if header.header_length < HEADER.size:
        raise Refused("length")
    end = header.header_length + header.payload_length
    if len(datagram) < end + CRC_BYTES:
        raise Refused("truncated")
    if len(datagram) > end + CRC_BYTES or len(datagram) > MAX_DATAGRAM:
        raise Refused("length")
    if crc32c(datagram[:end]) != int.from_bytes(datagram[end:], "little"):
        raise Refused("crc")
    if header.index >= header.count:
        raise Refused("field")
    return header, datagram[header.header_length : end]


class Frame:
    """One frame being put together. What does not arrive stays 0."""

    def __init__(self, header):
        self.common = self.common_of(header)
        self.header = header
        pixels = header.width * header.height
        self.images = {name: bytearray(pixels * size) for name, size in KINDS.values()}
        self.arrived = set()

    @staticmethod
    def common_of(header):
        return header.freshness, header.exposure, header.count, header.width, header.height

    def complete(self):
        return len(self.arrived) == self.header.count

    def add(self, header, payload):
        if self.common_of(header) != self.common:
            raise Refused("field")
        if header.index in self.arrived:
            raise Refused("duplicate")
        kind = KINDS.get((header.stream, header.codec)) if header.type == TILE else None
        if kind:
            self.place(kind, header, payload)
        self.arrived.add(header.index)
        if not kind and header.type != FRAME_INFO:
            raise Refused("unknown")

    def place(self, kind, header, payload):
        name, size = kind
        first = header.first_row * header.width + header.first_column
        end = first + header.pixel_count
        if (
            header.pixel_count == 0
            or header.first_column >= header.width
            or end > header.width * header.height
            or len(payload) != header.pixel_count * size
        ):
            raise Refused("field")
        self.images[name][first * size : end * size] = payload

    def line(self):
        crc = 0
        for name in ("depth", "width", "source"):
            crc = crc32c(self.images[name], crc)
        header = self.header
        return (
            f"frame {header.number} {header.width}x{header.height}"
            f" packets {len(self.arrived)}/{header.count} crc {crc:08x}"
        )


class Receiver:
    """Datagrams in, closed frames out, in the order of their numbers."""

    def __init__(self):
        self.device = None
        self.session = None
        self.ended = set()
        self.refused = collections.Counter()
        self.begin_session(None)

    def begin_session(self, session):
        if self.session is not None:
            self.ended.add(self.session)
        self.session = session
        self.open = {}
        self.last_closed = None
        self.freshness = None

    def push(self, datagram):
        """The frames that this datagram closes."""
        try:
            header, payload = parse(datagram)
            if self.device is None:
                self.device = header.device
            if header.device != self.device or header.session in self.ended:
                raise Refused("foreign")
            if header.session != self.session:
                self.begin_session(header.session)
            if header.type < FIRST_OWN_COUNTING:
                return self.push_part(header, payload)
            if header.type != CALIBRATION:
                raise Refused("unknown")
        except Refused as cause:
            self.refused[str(cause)] += 1
        return []

    def push_part(self, header, payload):
        if header.type == FRAME_INFO and len(payload) < FRAME_INFO_BYTES:
            raise Refused("field")
        number = header.number
        if self.last_closed is not None and ahead(number, self.last_closed) <= 0:
            raise Refused("late")
        if any(ahead(other, number) >= 2 for other in self.open):
            raise Refused("late")
        closed = self.close(lambda other: ahead(number, other) >= 2)
        frame = self.open.setdefault(number, Frame(header))
        try:
            frame.add(header, payload)
        except Refused as cause:
            self.refused[str(cause)] += 1
        if frame.complete():
            closed += self.close(lambda other: ahead(number, other) >= 0)
        return closed

    def close(self, condition):
        closed = []
        oldest_first = sorted(self.open, key=lambda n: min(ahead(n, m) for m in self.open))
        for number in oldest_first:
            if condition(number):
                frame = self.open.pop(number)
                self.last_closed = number
                fresh = frame.header.freshness
                if ahead(fresh, self.freshness) > 0 if self.freshness is not None else fresh != 0:
                    self.freshness = fresh
                    closed.append(frame)
                else:
                    self.refused["stale frame"] += 1
        return closed


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--address", default="0.0.0.0")
    parser.add_argument("--port", type=int, default=7560, help="0: any free one, printed")
    parser.add_argument("--frames", type=int, default=0, help="stop after so many; 0: never")
    options = parser.parse_args()
    endpoint = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    endpoint.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4 << 20)
    endpoint.bind((options.address, options.port))
    print(f"listening {endpoint.getsockname()[1]}", flush=True)
    receiver = Receiver()
    frames = 0
    while options.frames == 0 or frames < options.frames:
        for frame in receiver.push(endpoint.recv(65536)):
            print(frame.line(), flush=True)
            frames += 1
    refused = " ".join(f"{cause} {count}" for cause, count in sorted(receiver.refused.items()))
    print(f"refused {refused}", flush=True)


if __name__ == "__main__":
    main()
