"""Packets and pixels as docs/WIRE.md describes them: parse() verifies a datagram, pixels_of() reads a tile.
For receiver.py, and like it written from that page alone."""

import collections
import struct

HEADER = struct.Struct("<4sBBBBIIBBBBIqIHHHHHHHH")  # without the payload and the CRC
CRC_BYTES = 4
MAX_DATAGRAM = 1232
TILE, FRAME_INFO = 1, 2
CALIBRATION, HEALTH, PARITY, EVENT, ANNOUNCE, SECTORS = 64, 65, 66, 67, 68, 69
RAW_INFO, RAW_TILE = 70, 71
SUBSCRIBE, SUBSCRIBED, UNSUBSCRIBE = 128, 129, 130
FIRST_OWN_COUNTING = 64
FRAME_INFO_BYTES = 256
CALIBRATION_BYTES = 120
HEALTH_BYTES = 236
EVENT_PAYLOAD = struct.Struct("<IBBBBIIqI")
PARITY_FIELDS = struct.Struct("<HBBBBHHHHHH")
SUBSCRIBE_PAYLOAD = struct.Struct("<IHHQ4xBBH8x")
SUBSCRIBED_PAYLOAD = struct.Struct("<IBBHQ")
RAW16, RAW8, RVL16, RVL8, POINTS = 1, 2, 3, 4, 5
# stream: name, bytes of a pixel, codecs
STREAMS = {
    1: ("depth", 2, (RAW16, RVL16)),
    2: ("width", 2, (RAW16, RVL16)),
    3: ("source", 1, (RAW8, RVL8)),
    4: ("disparity", 2, (RAW16, RVL16)),
    5: ("pmd raw", 2, (RAW16, RVL16)),
    6: ("grey left", 1, (RAW8, RVL8)),
    7: ("grey right", 1, (RAW8, RVL8)),
    8: ("cloud", 8, (POINTS,)),
}
SCALED = 1, 2  # streams
SOURCE = 3

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


def rvl_numbers(payload):
    """The numbers of the whole payload, with what fills the last word, and the nibbles up to each."""
    number = shift = nibbles = 0
    for (word,) in struct.iter_unpack("<I", payload):
        for at in (28, 24, 20, 16, 12, 8, 4, 0):
            nibble = word >> at & 15
            nibbles += 1
            number |= (nibble & 7) << shift
            shift += 3
            if nibble < 8:
                if shift > 18:
                    raise Refused("field")
                yield number, nibbles
                number = shift = 0
    if shift:
        raise Refused("field")


def rvl(payload, count, size):
    """The pixels of a tile, as bytes; raises Refused."""
    if len(payload) % 4:
        raise Refused("field")
    mask = (1 << 8 * size) - 1
    numbers = rvl_numbers(payload)
    values, before, nibbles = [], 0, 0
    try:
        while len(values) < count:
            zeros, nibbles = next(numbers)
            others, nibbles = next(numbers)
            if len(values) + zeros + others > count or (others == 0 and len(values) + zeros < count):
                raise Refused("field")
            values += [0] * zeros
            for _ in range(others):
                code, nibbles = next(numbers)
                before = (before + (code >> 1 ^ -(code & 1))) & mask
                values.append(before)
    except StopIteration:
        raise Refused("field") from None
    if 2 * len(payload) - nibbles > 7 or any(number for number, _ in numbers):
        raise Refused("field")
    return struct.pack(f"<{count}{'H' if size == 2 else 'B'}", *values)


def pixels_of(header, payload):
    """The pixels of a tile of a known kind, as bytes; raises Refused."""
    _, size, _ = STREAMS[header.stream]
    if (
        header.pixel_count == 0
        or header.first_column >= header.width
        or header.first_row * header.width + header.first_column + header.pixel_count > header.width * header.height
    ):
        raise Refused("field")
    scale = header.flags & 15
    steps = header.flags & 16
    if (scale and header.stream not in SCALED) or (steps and header.stream != SOURCE):
        raise Refused("field")
    if header.codec in (RVL16, RVL8):
        payload = rvl(payload, header.pixel_count, size)
    if len(payload) != header.pixel_count * size:
        raise Refused("field")
    if steps:
        payload = summed(payload, header)
    return scaled(payload, scale) if scale else payload


def summed(steps, header):
    pixels = bytearray(steps)
    for i in range(1, len(pixels)):
        if (header.first_column + i) % header.width:
            pixels[i] ^= pixels[i - 1]
    return bytes(pixels)


def scaled(pixels, scale):
    values = [value << scale for (value,) in struct.iter_unpack("<H", pixels)]
    if max(values) > 65535:
        raise Refused("field")
    return struct.pack(f"<{len(values)}H", *values)


def groups_of(count):
    return (count + 15) // 16


def exclusive_or(blocks):
    total = 0
    for block in blocks:
        total ^= int.from_bytes(block, "little")
    return total.to_bytes(MAX_DATAGRAM, "little")
