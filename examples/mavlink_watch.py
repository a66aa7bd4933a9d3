#!/usr/bin/env python3
"""mavlink_watch.py [PORT]: what a sensor tells an autopilot by MAVLink over UDP (14550; 0: any free port): where the nearest obstacle may be."""

import socket
import struct
import sys

CRC_EXTRA = {0: 50, 132: 85, 330: 23}  # HEARTBEAT, DISTANCE_SENSOR, OBSTACLE_DISTANCE


def crc(data):
    value = 0xFFFF
    for byte in data:
        step = (byte ^ value) & 0xFF
        step = (step ^ step << 4) & 0xFF
        value = value >> 8 ^ step << 8 ^ step << 3 ^ step >> 4
    return value


def messages(data):
    """(id, payload with the zeros that version 2 leaves out) of each whole message; the rest of data."""
    found = []
    while (start := data.find(b"\xfd")) >= 0 and len(data) - start >= 12 and len(data) - start >= 12 + data[start + 1]:
        message, end = data[start:start + 10 + data[start + 1]], start + 12 + data[start + 1]
        kind = int.from_bytes(message[7:10], "little")
        if kind in CRC_EXTRA and crc(message[1:] + bytes([CRC_EXTRA[kind]])) == int.from_bytes(data[end - 2:end], "little"):
            found.append((kind, message[10:].ljust(167, b"\0")))
            data = data[end:]
        else:
            data = data[start + 1:]
    return found, data


receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
receiver.bind(("", int(sys.argv[1]) if len(sys.argv) > 1 else 14550))
print(f"listening at UDP port {receiver.getsockname()[1]}", flush=True)
data = b""
while True:
    found, data = messages(data + receiver.recv(65536))
    for kind, payload in found:
        if kind == 330:
            distances, farthest = struct.unpack_from("<72H", payload, 8), struct.unpack_from("<H", payload, 154)[0]
            increment, offset = struct.unpack_from("<2f", payload, 158)
            known = [(distance, offset + increment * number) for number, distance in enumerate(distances) if distance <= farthest]
            print(f"nearest {min(known)[0]} cm at {min(known)[1]:+.1f} degrees" if known else "nothing known", flush=True)
