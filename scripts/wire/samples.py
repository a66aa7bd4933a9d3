"""Bytes of a sensor that Python makes: RVL, COBS, MAVLink, one packet of each message. For seeds and tests."""

import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "host/python"))
import stof_wire as wire  # noqa: E402

DEVICE, SESSION = 0x0A0B0C0D, 0x11223344
STAMP = {"number": 7, "freshness": 6, "exposure_middle_ns": 1_234_567_890_123, "health": wire.Health.DEGRADED,
         "clock": wire.ClockState.EMULATED}


def seal(kind, payload, **fields):
    """A datagram of the sample sensor."""
    origin = wire.Origin(device_id=DEVICE, session_id=SESSION)
    return wire.seal(wire.Header(**{"type": kind, "origin": origin, **STAMP, **fields}), payload)


def rvl(values, bits):
    """docs/WIRE.md, "RVL"."""
    nibbles, before, at = [], 0, 0

    def put(number):
        while number > 7:
            nibbles.append(number & 7 | 8)
            number >>= 3
        nibbles.append(number)

    while at < len(values):
        for zero in (True, False):
            end = at
            while end < len(values) and (values[end] == 0) == zero:
                end += 1
            put(end - at)
            for value in values[at:end] if not zero else ():
                difference = (value - before) % (1 << bits)
                signed = difference - (1 << bits) if difference >> (bits - 1) else difference
                put(2 * signed if signed >= 0 else -2 * signed - 1)
                before = value
            at = end
    nibbles += [0] * (-len(nibbles) % 8)
    return b"".join(struct.pack("<I", int("".join(f"{n:x}" for n in nibbles[i:i + 8]), 16))
                    for i in range(0, len(nibbles), 8))


def cobs(data):
    """With the 0 that ends it."""
    out = bytearray()
    for i, piece in enumerate(pieces := data.split(b"\0")):
        while len(piece) > 254 or (len(piece) == 254 and i + 1 < len(pieces)):
            out += b"\xff" + piece[:254]
            piece = piece[254:]
        out += bytes([len(piece) + 1]) + piece
    return bytes(out) + b"\0"


def x25(data):
    """CRC-16/MCRF4XX, of MAVLink."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0x8408 if crc & 1 else 0)
    return crc


def mavlink2(number, extra, payload, sequence=0, system=1, component=1):
    """A MAVLink 2 frame; `extra` is the CRC_EXTRA of its message."""
    payload = payload.rstrip(b"\0") or payload[:1]
    body = struct.pack("<BBBBBB", len(payload), 0, 0, sequence, system, component)
    body += number.to_bytes(3, "little") + payload
    return b"\xfd" + body + struct.pack("<H", x25(body + bytes([extra])))


def mavlink1(number, extra, payload, sequence=0, system=1, component=1):
    body = struct.pack("<BBBBB", len(payload), sequence, system, component, number) + payload
    return b"\xfe" + body + struct.pack("<H", x25(body + bytes([extra])))


def messages():
    """{name: datagram}: one of each message, its numbers 0 but for a few."""
    found = {}
    for kind, message in wire.MESSAGES.items():
        payload = message().pack()
        if kind == wire.PacketType.PARITY:
            payload = wire.ParityFields(count=4, type=1, payload_length=16).pack() + bytes(192)
        if kind == wire.PacketType.SETTINGS_REQUEST:
            payload += b'{"streams":{"depth":"rvl"}}'
        if kind == wire.PacketType.SETTINGS_ANSWER:
            payload += b"streams.depth: takes off, raw, rvl or fit"
        if kind == wire.PacketType.FRAME_INFO:
            payload = wire.FrameInfo(tiles=(1, 1, 1, 0, 0, 0, 0, 0), pmd_present=1).pack()
        if kind == wire.PacketType.CALIBRATION:
            payload = wire.CalibrationPacket(image_width=4, image_height=2, fx=60 << 16, fy=60 << 16, period_ns=33_333_000,
                                             baseline_nm=100_000_000).pack()
        count = 4 if kind == wire.PacketType.FRAME_INFO else 1
        size = {"image_width": 4, "image_height": 2} if kind < 128 else {}
        found[kind.name.lower()] = seal(kind, payload, count=count, **size)
    return found


DEPTH = (4000, 4001, 4002, 0, 8000, 8010, 65535, 1)


def tile(stream, codec, payload, index, count=4, **fields):
    size = {"image_width": 4, "image_height": 2, "pixel_count": 8}
    return seal(wire.PacketType.TILE, payload, stream=stream, codec=codec, index=index, count=count, **{**size, **fields})


def raw_exposure(number=1):
    """The datagrams of raw pictures: 4 x 2 pixels of each eye, 2 x 1 of the PMD camera."""
    info = wire.RawInfo(number=number, width=4, height=2, camera_width=4, camera_height=2, pmd_width=2, pmd_height=1, pictures=7, step=1)
    eye = {"codec": wire.Codec.RAW8, "image_width": 4, "image_height": 2, "pixel_count": 4, "count": 6, "freshness": number}
    return [seal(wire.PacketType.RAW_INFO, info.pack(), count=6, freshness=number)] + [
        seal(wire.PacketType.RAW_TILE, bytes(range(4)), stream=stream, first_row=row, index=1 + 2 * (stream - 16) + row, **eye)
        for stream in (wire.Stream.RAW_LEFT, wire.Stream.RAW_RIGHT) for row in (0, 1)] + [
        seal(wire.PacketType.RAW_TILE, struct.pack("<8H", *range(8)), stream=wire.Stream.RAW_PMD, codec=wire.Codec.RAW16, index=5,
             count=6, freshness=number, image_width=2, image_height=4, pixel_count=8)]


def frame(coded):
    """The datagrams of a frame of 4 x 2 pixels: frame info, depth, width, source."""
    raw16, raw8 = struct.pack("<8H", *DEPTH), bytes(range(1, 9))
    width = struct.pack("<8H", *(4 if depth else 0 for depth in DEPTH))
    info = seal(wire.PacketType.FRAME_INFO, wire.FrameInfo(tiles=(1, 1, 1, 0, 0, 0, 0, 0)).pack(), count=4,
                image_width=4, image_height=2)
    if not coded:
        return [info, tile(1, 1, raw16, 1), tile(2, 1, width, 2), tile(3, 2, raw8, 3)]
    return [info, tile(1, 3, rvl(DEPTH, 16), 1), tile(2, 3, rvl(struct.unpack("<8H", width), 16), 2),
            tile(3, 4, rvl(raw8, 8), 3)]
