"""USB devices that a program on the host serves to a virtual machine: the usbredir protocol.

QEMU's usb-redir device speaks it on a stream socket (https://www.spice-space.org/usbredir.html). A
subclass of Device says what the device is and answers its requests; plug() connects, unplug() breaks
the connection, which the guest sees as pulling the plug.
"""

import collections
import socket
import struct
import threading
import time

# Packets.
HELLO, CONNECT, DISCONNECT, RESET, INTERFACES, ENDPOINTS = 0, 1, 2, 3, 4, 5
SET_CONFIGURATION, GET_CONFIGURATION, CONFIGURATION_STATUS = 6, 7, 8
SET_ALTERNATE, GET_ALTERNATE, ALTERNATE_STATUS = 9, 10, 11
CANCEL, DISCONNECT_ACK = 21, 24
CONTROL, BULK = 100, 101
# Capabilities.
DEVICE_VERSION, ENDPOINT_SIZES, LONG_IDS, LONG_BULK = 1, 4, 5, 6
CAPABILITIES = 1 << DEVICE_VERSION | 1 << ENDPOINT_SIZES | 1 << LONG_IDS | 1 << LONG_BULK
# Status of a transfer.
SUCCESS, CANCELLED, INVALID, IO_ERROR, STALL, TIMEOUT = range(6)
HIGH_SPEED = 2
TYPE_CONTROL, TYPE_BULK, TYPE_NONE = 0, 2, 255

SHORT_HEADER = struct.Struct("<III")  # type, length, id
LONG_HEADER = struct.Struct("<IIQ")
CONTROL_HEADER = struct.Struct("<BBBBHHH")  # endpoint, request, type, status, value, index, length
BULK_HEADER = struct.Struct("<BBHIH")  # endpoint, status, length, stream, high half of the length
DEVICE_HEADER = struct.Struct("<BBBBHHH")  # speed, class, subclass, protocol, vendor, product, version
HELLO_BYTES = 64
CONNECT_S = 10.0
BEFORE_FREE_S = 0.01

GET_STATUS, CLEAR_FEATURE, GET_DESCRIPTOR = 0, 1, 6
IN = 0x80
DESCRIPTOR_DEVICE, DESCRIPTOR_CONFIGURATION, DESCRIPTOR_STRING = 1, 2, 3

Interface = collections.namedtuple("Interface", "number cls subclass protocol")
Endpoint = collections.namedtuple("Endpoint", "address kind size interface")
Pending = collections.namedtuple("Pending", "id endpoint length stream")


class Gone(Exception):
    """The other side has closed the connection."""


def slot(address):
    """Where an endpoint stands in the tables of ENDPOINTS."""
    return (address & IN) >> 3 | address & 15


class Device:
    """One device. Its requests are answered on a thread of its own, which ends with unplug().

    A subclass sets vendor, product, cls, interfaces, endpoints, device_descriptor,
    configuration_descriptor and strings, and overrides control(), powered() and stopped().
    """

    vendor = 0x1209
    product = 0
    cls = (0, 0, 0)
    interfaces = ()
    endpoints = ()
    device_descriptor = b""
    configuration_descriptor = b""
    strings = ()

    def __init__(self, path):
        self.path = str(path)
        self.lock = threading.RLock()  # of all that follows; also of a subclass's state
        self.socket = None
        self.thread = None
        self.long_ids = False
        self.waiting = collections.deque()  # bulk IN requests that have no data yet
        self.outgoing = collections.deque()  # [memoryview, ends with a short packet] that nobody asked for yet

    # What a subclass does.

    def control(self, kind, request, value, index, length, data):
        """Class and vendor requests: the bytes to return (b"" for OUT); None stalls."""
        return None

    def powered(self):
        """The device was plugged in: it forgets everything. Called with the lock held."""

    def stopped(self):
        """The host cleared the bulk endpoint or reset the device. Called with the lock held."""

    # Plugging.

    @property
    def plugged(self):
        return self.socket is not None

    def plug(self):
        end = time.monotonic() + CONNECT_S
        connection = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        while True:
            try:
                connection.connect(self.path)
                break
            except OSError:
                if time.monotonic() > end:
                    connection.close()
                    raise
                time.sleep(BEFORE_FREE_S)
        with self.lock:
            self.socket = connection
            self.long_ids = False
            self._forget()
            self.powered()
            self._send(HELLO, 0, b"stof".ljust(HELLO_BYTES, b"\0") + struct.pack("<I", CAPABILITIES))
        self.thread = threading.Thread(target=self._serve, args=(connection,), daemon=True)
        self.thread.start()

    def unplug(self):
        with self.lock:
            connection, self.socket = self.socket, None
            self._forget()
        if connection is None:
            return
        try:
            connection.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        if self.thread is not threading.current_thread():
            self.thread.join()
        connection.close()

    # Bulk data.

    def send(self, data, short_end):
        """Delivers a message as the guest asks for it. short_end: a short packet ends it, of no bytes where needed."""
        with self.lock:
            if self.socket is not None:
                self.outgoing.append([memoryview(data).cast("B"), short_end])
                self._pump()

    def unsent(self):
        with self.lock:
            return len(self.outgoing)

    def drop_unsent(self):
        with self.lock:
            self.outgoing.clear()

    def _pump(self):
        packet = self.endpoints[-1].size
        while self.waiting and self.outgoing:
            message = self.outgoing[0]
            data, short_end = message
            pending = self.waiting.popleft()
            part = data[:pending.length]
            message[0] = data[len(part):]
            if not message[0]:
                whole = len(part) == pending.length and len(part) % packet == 0
                if short_end and whole and len(part):
                    pass  # an empty packet is still to follow
                else:
                    self.outgoing.popleft()
            self._reply_bulk(pending, part)

    def _reply_bulk(self, pending, data, status=SUCCESS):
        size = len(data)
        self._send(BULK, pending.id, BULK_HEADER.pack(pending.endpoint, status, size & 0xFFFF, pending.stream,
                                                      size >> 16), data)

    # The protocol.

    def _forget(self):
        self.waiting.clear()
        self.outgoing.clear()

    def _send(self, kind, ident, body, data=b""):
        if self.socket is None:
            return
        header = LONG_HEADER if self.long_ids else SHORT_HEADER
        parts = [header.pack(kind, len(body) + len(data), ident), body, data]
        try:
            sent = self.socket.sendmsg(parts)
            total = sum(map(len, parts))
            if sent < total:
                self.socket.sendall(b"".join(map(bytes, parts))[sent:])
        except OSError:
            pass  # the thread that reads notices

    def _serve(self, connection):
        reader = connection.makefile("rb", buffering=65536)

        def take(size):
            data = reader.read(size)
            if len(data) < size:
                raise Gone
            return data

        try:
            while True:
                header = LONG_HEADER if self.long_ids else SHORT_HEADER
                kind, length, ident = header.unpack(take(header.size))
                body = take(length)
                with self.lock:
                    if self.socket is not connection:
                        return
                    self._packet(kind, ident, body)
        except (Gone, OSError, ValueError):
            pass
        finally:
            reader.close()

    def _packet(self, kind, ident, body):
        if kind == HELLO:
            theirs = struct.unpack_from("<I", body, HELLO_BYTES)[0] if len(body) >= HELLO_BYTES + 4 else 0
            self.long_ids = bool(theirs >> LONG_IDS & 1)
            self._announce()
        elif kind == BULK:
            endpoint, _, low, stream, high = BULK_HEADER.unpack_from(body)
            self.waiting.append(Pending(ident, endpoint, low | high << 16, stream))
            self._pump()
        elif kind == CONTROL:
            self._control(ident, body)
        elif kind == CANCEL:
            self._cancel(ident)
        elif kind == RESET:
            self._forget()
            self.stopped()
        elif kind == SET_CONFIGURATION:
            self._send(CONFIGURATION_STATUS, ident, bytes((SUCCESS, body[0])))
        elif kind == GET_CONFIGURATION:
            self._send(CONFIGURATION_STATUS, ident, bytes((SUCCESS, 1)))
        elif kind == SET_ALTERNATE:
            self._send(ALTERNATE_STATUS, ident, bytes((SUCCESS, body[0], body[1])))
        elif kind == GET_ALTERNATE:
            self._send(ALTERNATE_STATUS, ident, bytes((SUCCESS, body[0], 0)))

    def _announce(self):
        kinds, intervals, interfaces, sizes = bytearray([TYPE_NONE] * 32), bytes(32), bytearray(32), [0] * 32
        kinds[slot(0)] = kinds[slot(IN)] = TYPE_CONTROL
        sizes[slot(0)] = sizes[slot(IN)] = 64
        for endpoint in self.endpoints:
            at = slot(endpoint.address)
            kinds[at], sizes[at], interfaces[at] = endpoint.kind, endpoint.size, endpoint.interface
        self._send(ENDPOINTS, 0, bytes(kinds) + intervals + bytes(interfaces) + struct.pack("<32H", *sizes))
        columns = [bytes(column).ljust(32, b"\0") for column in zip(*self.interfaces)]
        self._send(INTERFACES, 0, struct.pack("<I", len(self.interfaces)) + b"".join(columns))
        self._send(CONNECT, 0, DEVICE_HEADER.pack(HIGH_SPEED, *self.cls, self.vendor, self.product, 0x0100))

    def _control(self, ident, body):
        endpoint, request, kind, _, value, index, length = CONTROL_HEADER.unpack_from(body)
        data = self._standard(kind, request, value, index)
        if data is None:
            data = self.control(kind, request, value, index, length, body[CONTROL_HEADER.size:])
        if data is None:
            self._send(CONTROL, ident, CONTROL_HEADER.pack(endpoint, request, kind, STALL, value, index, 0))
            return
        data = data[:length] if kind & IN else b""
        size = len(data) if kind & IN else length
        self._send(CONTROL, ident, CONTROL_HEADER.pack(endpoint, request, kind, SUCCESS, value, index, size), data)

    def _standard(self, kind, request, value, index):
        if kind == IN and request == GET_DESCRIPTOR:
            return self._descriptor(value >> 8, value & 255)
        if kind & 0x7F < 3 and request == GET_STATUS and kind & IN:
            return b"\0\0"
        if kind == 0x02 and request == CLEAR_FEATURE:
            self.outgoing.clear()
            self.stopped()
            return b""
        return None

    def _descriptor(self, kind, number):
        if kind == DESCRIPTOR_DEVICE:
            return self.device_descriptor
        if kind == DESCRIPTOR_CONFIGURATION:
            return self.configuration_descriptor
        if kind == DESCRIPTOR_STRING and number == 0:
            return bytes((4, DESCRIPTOR_STRING, 0x09, 0x04))
        if kind == DESCRIPTOR_STRING and number <= len(self.strings):
            text = self.strings[number - 1].encode("utf-16-le")
            return bytes((2 + len(text), DESCRIPTOR_STRING)) + text
        return None

    def _cancel(self, ident):
        for pending in self.waiting:
            if pending.id == ident:
                self.waiting.remove(pending)
                self._reply_bulk(pending, b"", CANCELLED)
                return


def device_descriptor(cls, vendor, product, version=0x0100):
    """With three strings: manufacturer, product, serial number."""
    return struct.pack("<BBHBBBBHHHBBBB", 18, DESCRIPTOR_DEVICE, 0x0200, *cls, 64, vendor, product, version, 1, 2, 3, 1)


def configuration_descriptor(interfaces, body):
    return struct.pack("<BBHBBBBB", 9, DESCRIPTOR_CONFIGURATION, 9 + len(body), interfaces, 1, 0, 0x80, 50) + body


def interface_descriptor(number, endpoints, cls, subclass, protocol, text=0):
    return bytes((9, 4, number, 0, endpoints, cls, subclass, protocol, text))


def bulk_descriptor(address, size):
    return struct.pack("<BBBBHB", 7, 5, address, TYPE_BULK, size, 0)
