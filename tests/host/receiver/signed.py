"""Signed requests and streams of docs/WIRE.md in plain Python, written from that page and RFC 8439. Slow; for tests."""

import hashlib
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "host/python"))
import stof_wire as wire  # noqa: E402

HEADER, SIGNATURE_AT, TAG_AT, SIGNED_HEADER, CRC = 52, 52, 64, 80, 4
SIGNED_FIELDS, TAG, SUBSCRIBED, STREAM_KEY = 24, 16, 16, 40
IN_BLOCK, TAGS = 16, 1
MASK = 0xFFFFFFFF
ROUNDS = ((0, 4, 8, 12), (1, 5, 9, 13), (2, 6, 10, 14), (3, 7, 11, 15),
          (0, 5, 10, 15), (1, 6, 11, 12), (2, 7, 8, 13), (3, 4, 9, 14))


def chacha20_block(key, counter, nonce):
    """RFC 8439, 2.3."""
    start = [*struct.unpack("<4I", b"expand 32-byte k"), *struct.unpack("<8I", key), counter, *struct.unpack("<3I", nonce)]
    state = start[:]

    def step(a, b, d, turn):
        state[a] = state[a] + state[b] & MASK
        word = state[d] ^ state[a]
        state[d] = (word << turn | word >> (32 - turn)) & MASK

    for _ in range(10):
        for a, b, c, d in ROUNDS:
            step(a, b, d, 16)
            step(c, d, b, 12)
            step(a, b, d, 8)
            step(c, d, b, 7)
    return struct.pack("<16I", *((was + now) & MASK for was, now in zip(start, state)))


def poly1305(message, key):
    """RFC 8439, 2.5."""
    r = int.from_bytes(key[:16], "little") & 0x0FFFFFFC0FFFFFFC0FFFFFFC0FFFFFFF
    total = 0
    for i in range(0, len(message), 16):
        total = (total + int.from_bytes(message[i:i + 16] + b"\1", "little")) * r % ((1 << 130) - 5)
    return (total + int.from_bytes(key[16:32], "little") & (1 << 128) - 1).to_bytes(16, "little")


def counted_tag(key, number, counter, data):
    """Poly1305 with the one-time key of that counter: keys of 32 bytes, 16 of one keystream."""
    nonce, place = struct.pack("<IQ", number, counter // IN_BLOCK), counter % IN_BLOCK
    once = chacha20_block(key, place // 2, nonce)[32 * (place % 2):][:32]
    return poly1305(data, once)


def signature(datagram):
    """(number, counter, tag) of a datagram that wire.parse() took; None: it is not signed."""
    if datagram[6] < SIGNED_HEADER:
        return None
    number, counter = struct.unpack_from("<IQ", datagram, SIGNATURE_AT)
    return (number, counter, datagram[TAG_AT:SIGNED_HEADER]) if number else None


def signed_with(key, datagram):
    number, counter, tag = signature(datagram)
    return counted_tag(key, number, counter, datagram[:TAG_AT] + datagram[SIGNED_HEADER:-CRC]) == tag


def sign_request(secret, key_id, origin, kind, counter, payload):
    """A signed request, with what is signed in it."""
    fields = struct.pack("<IB3xQQ", key_id, kind, counter, 0)
    header = wire.Header(type=wire.PacketType.SIGNED_REQUEST, origin=origin)
    packet = wire.seal(header, fields + payload + bytes(TAG))[:-CRC - TAG]
    packet += hashlib.blake2b(packet, digest_size=TAG, key=secret).digest()
    return packet + wire.crc32c(packet).to_bytes(CRC, "little")


def open_answer(secret, datagram):
    """(type, counter, payload) of a signed answer; raises ValueError where the key did not sign it."""
    header, payload = wire.parse(datagram)
    if header.type != wire.PacketType.SIGNED_ANSWER:
        raise ValueError("not signed")
    tag = hashlib.blake2b(datagram[:-CRC - TAG], digest_size=TAG, key=secret).digest()
    if tag != payload[-TAG:]:
        raise ValueError("signed with another key")
    _, kind, counter, _ = struct.unpack_from("<IB3xQQ", payload)
    return kind, counter, payload[SIGNED_FIELDS:-TAG]


def open_stream_key(secret, key_id, origin, counter, payload):
    """(number, key) that follows the `subscribed`."""
    number, tags = struct.unpack_from("<IB", payload, SUBSCRIBED)
    if tags != TAGS:
        raise ValueError(f"tags are made in another way: {tags}")
    text = b"stof stream key 1" + struct.pack("<IIIQ", origin.device_id, origin.session_id, key_id, counter)
    pad = hashlib.blake2b(text, digest_size=32, key=secret).digest()
    sealed = payload[SUBSCRIBED + 8:SUBSCRIBED + STREAM_KEY]
    return number, bytes(a ^ b for a, b in zip(sealed, pad))
