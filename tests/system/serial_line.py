"""The host's end of the guest's serial line: packets of the wire in COBS frames."""

import pathlib
import socket
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent.parent / "host" / "python"))

import stof_wire

MOST_BYTES = 65536


def cobs_decode(data):
    """The bytes of one frame, without its zero; None: it is no frame."""
    out, at = bytearray(), 0
    while at < len(data):
        code = data[at]
        if code == 0 or at + code > len(data):
            return None
        out += data[at + 1:at + code]
        at += code
        if code < 255 and at < len(data):
            out.append(0)
    return bytes(out)


class SerialLine:
    """Counts what comes by the line while it is held."""

    def __init__(self, machine):
        self.socket = machine.serial()
        self.rest = b""
        self.packets = []  # headers
        self.damaged = 0

    def read(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self.socket.settimeout(left)
            try:
                part = self.socket.recv(MOST_BYTES)
            except (socket.timeout, TimeoutError):
                break
            if not part:
                break
            *frames, self.rest = (self.rest + part).split(b"\0")
            for frame in filter(None, frames):
                self._take(frame)

    def _take(self, frame):
        try:
            datagram = cobs_decode(frame)
            self.packets.append(stof_wire.parse(datagram or b"")[0])
        except stof_wire.Refused:
            self.damaged += 1

    def frames(self, seconds):
        """How many different frames the packets of the next seconds are of."""
        since = len(self.packets)
        self.read(seconds)
        return len({packet.number for packet in self.packets[since:] if packet.freshness})

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()
