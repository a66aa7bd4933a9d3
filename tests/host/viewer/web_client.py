"""A WebSocket client (RFC 6455) in plain Python: what a page says and gets, and what no browser would send."""

import base64
import json
import os
import socket
import struct

SUBPROTOCOL = "stof.view.v1"
ENOUGH_S = 60
TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10


class Refused(Exception):
    """status: of the answer; 0: the server closed without one."""

    def __init__(self, status):
        super().__init__(status)
        self.status = status


class Closed(Exception):
    """status: of the close frame; 0: the connection ended without one."""

    def __init__(self, status):
        super().__init__(status)
        self.status = status


def request(port, text):
    """The status of the answer to these bytes; 0: there was none. And the answer."""
    with socket.create_connection(("127.0.0.1", port), ENOUGH_S) as connection:
        answer = b""
        try:
            connection.sendall(text.encode())
            while True:
                part = connection.recv(65536)
                if not part:
                    break
                answer += part
                head, found, body = answer.partition(b"\r\n\r\n")
                size = next((int(line.split(b":")[1]) for line in head.split(b"\r\n") if line.lower().startswith(b"content-length:")), None)
                if found and size is not None and len(body) >= size:
                    break
        except ConnectionError:
            pass
    return (int(answer.split()[1]) if answer.startswith(b"HTTP/1.") else 0), answer


def get(port, path="/", host=None, method="GET", **headers):
    lines = [f"{method} {path} HTTP/1.1", f"Host: {host or f'127.0.0.1:{port}'}"]
    lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
    return request(port, "\r\n".join(lines) + "\r\n\r\n")


class WebSocket:
    """origin None: the server's own, "": none. address: of this machine, at which the server is asked."""

    def __init__(self, port, host=None, origin=None, token=None, subprotocol=SUBPROTOCOL, receive_buffer=None, address="127.0.0.1"):
        host = host or f"{address}:{port}"
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.settimeout(ENOUGH_S)
        self.socket.connect((address, port))
        self.received = b""
        self.told = {}  # the newest text message of each type
        lines = [f"GET /{'?token=' + token if token else ''} HTTP/1.1", f"Host: {host}", "Upgrade: websocket", "Connection: Upgrade",
                 f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}", "Sec-WebSocket-Version: 13"]
        lines += [f"Sec-WebSocket-Protocol: {subprotocol}"] if subprotocol else []
        origin = f"http://{host}" if origin is None else origin
        lines += [f"Origin: {origin}"] if origin else []
        self.socket.sendall(("\r\n".join(lines) + "\r\n\r\n").encode())
        head = b""
        while b"\r\n\r\n" not in head:
            try:
                part = self.socket.recv(4096)
            except ConnectionError:
                part = b""
            if not part:
                break
            head += part
        status = int(head.split()[1]) if head.startswith(b"HTTP/1.") else 0
        if status != 101:
            self.close()
            raise Refused(status)
        head, _, self.received = head.partition(b"\r\n\r\n")
        self.subprotocol = next((line.split(b":")[1].strip().decode() for line in head.split(b"\r\n")
                                 if line.lower().startswith(b"sec-websocket-protocol:")), "")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.socket.close()

    def send(self, payload, opcode=TEXT, final=True, masked=True):
        if not masked:
            self.socket.sendall(bytes([opcode | 0x80, len(payload)]) + payload)  # a short one
            return
        mask = os.urandom(4)
        size = len(payload)
        head = bytes([opcode | (0x80 if final else 0)])
        head += bytes([0x80 | size]) if size < 126 else struct.pack(">BH" if size < 65536 else ">BQ", 0x80 | (126 if size < 65536 else 127), size)
        self.socket.sendall(head + mask + bytes(byte ^ mask[at % 4] for at, byte in enumerate(payload)))

    def ask(self, *planes, frames=1, quiet=False):
        self.send(json.dumps({"show": planes, "frames": frames, "quiet": quiet}).encode())

    def _read(self, size):
        while len(self.received) < size:
            try:
                part = self.socket.recv(1 << 20)
            except ConnectionError as error:
                raise Closed(0) from error
            if not part:
                raise Closed(0)
            self.received += part
        taken, self.received = self.received[:size], self.received[size:]
        return taken

    def receive(self):
        """(opcode, payload) of the next message; answers pings."""
        while True:
            first, size = self._read(2)
            size &= 127
            if size == 126:
                size = struct.unpack(">H", self._read(2))[0]
            elif size == 127:
                size = struct.unpack(">Q", self._read(8))[0]
            payload = self._read(size)
            if first & 15 == CLOSE:
                raise Closed(struct.unpack(">H", payload[:2])[0] if len(payload) >= 2 else 0)
            if first & 15 == PING:
                self.send(payload, PONG)
                continue
            assert first & 0x80 and first & 15 in (TEXT, BINARY), first
            if first & 15 == TEXT:
                said = json.loads(payload)
                self.told[said.get("type", said.get("op"))] = said
            return first & 15, payload

    def message(self, kind):
        """The next text message of that type."""
        while True:
            opcode, payload = self.receive()
            if opcode == TEXT and json.loads(payload)["type"] == kind:
                return json.loads(payload)

    def until(self, kind, condition=lambda told: True):
        """The newest message of that type, which may have come already, once it is so."""
        while kind not in self.told or not condition(self.told[kind]):
            self.receive()
        return self.told[kind]

    def wish(self, what, ticket=None, number=1, **members):
        """Its answer. ticket None: the page's own."""
        self.want(what, ticket, number, **members)
        return self.message("answer")

    def want(self, what, ticket=None, number=1, **members):
        if ticket is None:
            ticket = self.until("rights")["ticket"]
        self.send(json.dumps({"do": what, "id": number, "ticket": ticket, **members}).encode())

    def frame(self):
        """(head, {plane: bytes}) of the next frame."""
        while True:
            opcode, payload = self.receive()
            if opcode == BINARY:
                break
        size = struct.unpack("<I", payload[:4])[0]
        head, at, planes = json.loads(payload[4:4 + size]), 4 + size, {}
        for plane in head["planes"]:
            width, height = head["left_size" if plane == "left" else "size"]
            end = at + width * height * (2 if plane in ("depth", "width") else 1)
            planes[plane], at = payload[at:end], end
        assert at == len(payload), (at, len(payload))
        return head, planes
