"""Finding sensors, and one of them: its frames, health and settings."""

from __future__ import annotations

import contextlib
import ctypes
import json
import math
import os
import threading
import time
import typing

from . import _library as c
from ._errors import BadArgument, Busy, Closed, End, NotFound, Timeout, error_of
from ._frame import Frame, Pool, Raw
from ._values import Answer, Clock, Document, Event, Found, Health, Link, LinkCondition, LinkEvent, Recorded, Setting

_OK, _TIMEOUT, _NOT_YET, _TOO_SMALL = 0, 1, 5, 7
_RAW = {"left": 1, "right": 2, "pmd": 4}
_RAW_COMPLETE = 8
_SLICE_S = 0.1  # how soon a Ctrl-C, or a close() of another thread, is seen
_GET, _SET, _STAGE, _COMMIT, _REVERT, _PRESET, _SAVE, _RESET = range(8)
_LINE = 512
_MOST_SENSORS = 256


def _milliseconds(seconds: float) -> int:
    if not 0 <= seconds <= 2_000_000:  # also NaN
        raise BadArgument(f"a timeout of {seconds} s: takes 0 to 2,000,000 seconds")
    return math.ceil(seconds * 1000)


def _encoded(text: str | None, what: str) -> bytes | None:
    if text is None:
        return None
    if not isinstance(text, str) or "\0" in text:
        raise BadArgument(f"{what} is {text!r}: takes a text without a zero character")
    return text.encode()


def _integer(value: int, most: int, what: str) -> int:
    if not isinstance(value, int) or not 0 <= value <= most:
        raise BadArgument(f"{what} is {value!r}: takes whole numbers from 0 to {most}")
    return value


def _check(status: int, why: bytes = b"") -> None:
    if status != _OK:
        raise error_of(status, c.text(why) or c.text(c.library.stof_status_text(status)))


def _nested(settings: typing.Mapping[str, typing.Any]) -> dict[str, typing.Any]:
    """{"a.b": 1} as {"a": {"b": 1}}, on every level; what both say is one object."""
    whole: dict[str, typing.Any] = {}
    for path, value in settings.items():
        *above, name = str(path).split(".")
        place = whole
        for one in above:
            place = place.setdefault(one, {})
            if not isinstance(place, dict):
                raise BadArgument(f"{path}: {one} has a value of its own already")
        if not isinstance(value, typing.Mapping):
            if isinstance(place.get(name), dict):
                raise BadArgument(f"{path}: has fields of its own already, and cannot have a value")
            place[name] = value
            continue
        inner = place.setdefault(name, {})
        if not isinstance(inner, dict):
            raise BadArgument(f"{path}: {name} has a value of its own already")
        _merge(inner, _nested(value))
    return whole


def _merge(into: dict[str, typing.Any], more: dict[str, typing.Any]) -> None:
    for name, value in more.items():
        if isinstance(value, dict) and isinstance(into.get(name), dict):
            _merge(into[name], value)
        else:
            into[name] = value


def discover(timeout: float = 2.5, addresses: typing.Iterable[str] = ()) -> list[Found]:
    """The sensors near, and those at `addresses` (HOST[:PORT]). Blocks for `timeout` seconds. From any thread. BadArgument."""
    if isinstance(addresses, str):
        addresses = (addresses,)
    texts = [_encoded(address, "an address") for address in addresses]
    array = (ctypes.c_char_p * len(texts))(*texts)
    found = (c.Found * _MOST_SENSORS)()
    count = ctypes.c_size_t()
    why = ctypes.create_string_buffer(_LINE)
    status = c.library.stof_discover(_milliseconds(timeout), array, len(texts), found, len(found), ctypes.sizeof(c.Found), count, why,
                                     len(why))
    if status != _TOO_SMALL:
        _check(status, why.value)
    return [Found.of(one) for one in found[:min(count.value, len(found))]]


def _find(serial: str | None, name: str | None, timeout: float, addresses: typing.Iterable[str]) -> Found:
    all_found = discover(timeout, addresses)
    fits = [one for one in all_found if (serial is None or one.serial == serial) and (name is None or one.name == name)]
    if len(fits) == 1:
        return fits[0]
    wanted = " and ".join(f"{what} {value!r}" for what, value in (("serial number", serial), ("name", name)) if value is not None)
    if fits:
        raise NotFound(f"{len(fits)} sensors have {wanted}: open one of {', '.join(one.endpoint for one in fits)} by its address")
    # What the network says may hold anything: as Python writes it.
    others = ", ".join(f"{one.serial!r} {one.name!r} at {one.endpoint}" for one in all_found)
    raise NotFound(f"no sensor with {wanted} answered within {timeout:g} s; found: {others or 'none'}")


class Sensor:
    """A subscription to one sensor; open() makes it. A context manager, and an iterator of frames.

    Threads: one at a time may wait for frames (next, frames, next_event, next_link_event: else Busy); everything else may be called from any
    thread, close() too: whoever waits then gets Closed. While a call waits, other Python threads run.
    """

    def __init__(self, handle: ctypes.c_void_p, place: str) -> None:
        self._handle = handle
        self._place = place
        self._pool = Pool()
        self._state = threading.Condition()
        self._users = 0
        self._receiving = False
        self._closed = False

    def __repr__(self) -> str:
        return f"<stof.Sensor {self._place}{', closed' if self._closed else ''}>"

    def __enter__(self) -> Sensor:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if not getattr(self, "_closed", True):
            self.close()

    def __iter__(self) -> typing.Iterator[Frame]:
        return self.frames()

    @property
    def closed(self) -> bool:
        return self._closed

    def close(self) -> None:
        """Ends the subscription. Frames and arrays that are held stay valid. Again: nothing."""
        with self._state:
            if self._closed:
                return
            self._closed = True
            self._state.wait_for(lambda: self._users == 0)
        c.library.stof_close(self._handle)
        self._pool.close()

    @contextlib.contextmanager
    def _use(self, receiving: bool = False) -> typing.Iterator[ctypes.c_void_p]:
        with self._state:
            if self._closed:
                raise Closed(f"the sensor at {self._place} was closed: open it again")
            if receiving and self._receiving:
                raise Busy(f"another thread waits for a frame of {self._place}: one at a time, or open it twice")
            self._users += 1
            self._receiving |= receiving
        try:
            yield self._handle
        finally:
            with self._state:
                self._users -= 1
                self._receiving &= not receiving
                self._state.notify_all()

    def next(self, timeout: float = 5.0) -> Frame:
        """The next frame, also an incomplete one. Blocks for `timeout` seconds at most, 0 only looks. Call it, or iterate, at least
        once a second: it keeps the subscription alive. Timeout, Lost, Busy, Closed, BadArgument, NoMemory; End: the recording is over."""
        left = _milliseconds(timeout)
        end = time.monotonic() + timeout
        with self._use(receiving=True) as handle:
            while True:
                raw = c.Frame(struct_size=ctypes.sizeof(c.Frame))
                status = c.library.stof_next(handle, min(left, round(_SLICE_S * 1000)), raw)
                if status == _OK:
                    return self._keep(raw)
                if status != _TIMEOUT:
                    _check(status)
                if self._closed:
                    raise Closed(f"the sensor at {self._place} was closed by another thread")
                left = math.ceil((end - time.monotonic()) * 1000)
                if left <= 0:
                    raise Timeout(f"no frame from {self._place} within {timeout:g} s{self._cause()}")

    def _cause(self) -> str:
        conditions = self.link().conditions
        if LinkCondition.NO_KEY in conditions:
            return ": the sensor knows none of your keys: pair with it (stof pair)"
        if LinkCondition.FORGED in conditions:
            return ": what came is forged, or not signed and should be"
        if LinkCondition.DELAYED in conditions:
            return ": what came was older than max_age_ms"
        return ""

    def _keep(self, raw: c.Frame) -> Frame:
        kept = ctypes.c_void_p(self._pool.take())
        status = c.library.stof_keep(raw, kept)
        if status != _OK:
            if kept.value is not None:
                self._pool.give(kept.value)
            _check(status)
        assert kept.value is not None
        return Frame(raw, kept.value, self._pool)

    def frames(self, timeout: float = 5.0) -> typing.Iterator[Frame]:
        """Frames until the sensor is closed, or the recording is over. Where none comes for `timeout` seconds: Timeout; else as next()."""
        while not self._closed:
            try:
                frame = self.next(timeout)
            except (Closed, End):
                return
            yield frame
            del frame  # its memory is the next one's, unless somebody holds it

    def fileno(self) -> int:
        """For select and poll: readable when next(0) has something to do. So is it after due() seconds in any case. -1: a recording,
        of which due() tells alone."""
        with self._use() as handle:
            return c.library.stof_fd(handle)

    def due(self) -> float:
        """Seconds until next(0) has something to do in any case. By the thread that waits for frames."""
        with self._use(receiving=True) as handle:
            return c.library.stof_due_ms(handle) / 1000

    def next_event(self) -> Event | None:
        """The next condition that began or ended, each once; look after every frame. None: no more. Busy, Closed."""
        raw = c.Event(struct_size=ctypes.sizeof(c.Event))
        with self._use(receiving=True) as handle:
            status = c.library.stof_next_event(handle, raw)
        if status == _TIMEOUT:
            return None
        _check(status)
        return Event.of(raw)

    def events(self) -> typing.Iterator[Event]:
        """Those that came so far."""
        while (event := self.next_event()) is not None:
            yield event

    def health(self) -> Health | None:
        """The newest that next() has read; None: none came yet. Closed."""
        raw = c.Health(struct_size=ctypes.sizeof(c.Health))
        with self._use() as handle:
            status = c.library.stof_get_health(handle, raw)
        if status == _NOT_YET:
            return None
        _check(status)
        return Health.of(raw)

    def link(self) -> Link:
        """As of now, also while nobody waits for frames. Closed."""
        raw = c.Link(struct_size=ctypes.sizeof(c.Link))
        with self._use() as handle:
            _check(c.library.stof_get_link(handle, raw))
        return Link.of(raw)

    def next_link_event(self) -> LinkEvent | None:
        """The next condition of the link that began or ended, each once, a restart among them; look after every frame, and after a
        Timeout. None: no more. Busy, Closed."""
        raw = c.LinkEvent(struct_size=ctypes.sizeof(c.LinkEvent))
        with self._use(receiving=True) as handle:
            status = c.library.stof_next_link_event(handle, raw)
        if status == _TIMEOUT:
            return None
        _check(status)
        return LinkEvent.of(raw)

    def next_raw(self) -> Raw | None:
        """The next exposure that next() has received beside frames, where open(raw=...) asked for it; look after every frame. None: no
        more. Unsupported: none was asked for; Refused: they take a key; NotYet: another subscriber has them. Busy, Closed."""
        raw = c.Raw(struct_size=ctypes.sizeof(c.Raw))
        with self._use(receiving=True) as handle:
            status = c.library.stof_next_raw(handle, raw)
            if status == _TIMEOUT:
                return None
            _check(status)
            return Raw(raw)

    def clock(self) -> Clock | None:
        """How the sensor's clock maps to this machine's; None: no frame has told it yet. Unsupported: its stamps are of emulated or
        recorded time. Closed."""
        raw = c.Clock(struct_size=ctypes.sizeof(c.Clock))
        with self._use() as handle:
            status = c.library.stof_get_clock(handle, raw)
        if status == _NOT_YET:
            return None
        _check(status)
        return Clock.of(raw)

    def record(self, file: str | os.PathLike[str], replace: bool = False) -> None:
        """What is received from now on goes to `file` as well, an MCAP file (docs/RECORDING.md), until end_recording() or close().
        Whoever waits for frames waits for no disk. replace: a file of that name is replaced. FileFailed: it is there, or cannot be made.
        Busy: it is recorded already. Unsupported: of a recording. Closed, BadArgument."""
        options = c.RecordOptions(struct_size=ctypes.sizeof(c.RecordOptions), replace=bool(replace))
        why = ctypes.create_string_buffer(_LINE)
        with self._use() as handle:
            _check(c.library.stof_record(handle, os.fsencode(file), options, why, len(why)), why.value)

    def end_recording(self) -> Recorded:
        """Blocks until all that was received is written. A file without any frame is removed. NotYet: nothing is recorded.
        FileFailed: the disk took less. Closed."""
        raw = c.Recorded(struct_size=ctypes.sizeof(c.Recorded))
        why = ctypes.create_string_buffer(_LINE)
        with self._use() as handle:
            _check(c.library.stof_record_end(handle, raw, why, len(why)), why.value)
        return Recorded.of(raw)

    def recorded(self) -> Recorded | None:
        """How far the recording is, or what came of the last one; None: none was begun. Closed."""
        raw = c.Recorded(struct_size=ctypes.sizeof(c.Recorded))
        with self._use() as handle:
            status = c.library.stof_get_recorded(handle, raw)
        if status == _NOT_YET:
            return None
        _check(status)
        return Recorded.of(raw)

    def setting(self, path: str) -> Setting:
        """One setting, such as "depth.max_range_mm", and what it takes. BadArgument: the sensor has none of that path; errors as get()."""
        raw = c.Setting(struct_size=ctypes.sizeof(c.Setting))
        why = ctypes.create_string_buffer(_LINE)
        with self._use() as handle:
            status = c.library.stof_get_setting(handle, _encoded(path, "the path"), raw, why, len(why))
        _check(status, why.value)
        return Setting.of(raw)

    def statistics(self) -> dict[str, int]:
        """What became of the packets and frames since open(), by cause: the names of stof_statistics in stof.h. Closed."""
        raw = c.Statistics(struct_size=ctypes.sizeof(c.Statistics))
        with self._use() as handle:
            _check(c.library.stof_get_statistics(handle, raw))
        return {name: getattr(raw, name) for name in (*c.COUNTERS, "socket_buffer")}

    def advice(self) -> str:
        """One line: what to change on this machine to lose less; empty: nothing. Closed."""
        space = ctypes.create_string_buffer(_LINE)
        with self._use() as handle:
            c.library.stof_advice(handle, space, len(space))
        return c.text(space.value)

    def get(self, document: Document = Document.ACTIVE) -> dict[str, typing.Any]:
        """Settings, as docs/SETTINGS.md has them. Blocks for about a second when nobody answers. Refused, Unreachable,
        Unsupported (no sensor was named), Lost, Closed."""
        return json.loads(self._request(_GET, document).text)

    def set(self, settings: typing.Mapping[str, typing.Any]) -> Answer:
        """Changes these fields, or nothing if one is refused: sensor.set({"streams": {"grey_left": "rvl"}}), or by their
        paths: sensor.set({"streams.grey_left": "rvl"}). Errors as get(); BadArgument: a path leads through a value."""
        return self._request(_SET, text=self._json(settings))

    def stage(self, settings: typing.Mapping[str, typing.Any]) -> Answer:
        """The same to the staged settings."""
        return self._request(_STAGE, text=self._json(settings))

    def commit(self) -> Answer:
        """The staged settings become the active ones and are saved."""
        return self._request(_COMMIT)

    def revert(self) -> Answer:
        """What is staged is forgotten."""
        return self._request(_REVERT)

    def preset(self, name: str) -> Answer:
        """A scene preset: "indoor", "outdoor" or "near"."""
        return self._request(_PRESET, text=_encoded(name, "the preset"))

    def save(self) -> Answer:
        """The active settings are those of the next start."""
        return self._request(_SAVE)

    def reset(self) -> Answer:
        """Every field's default."""
        return self._request(_RESET)

    @staticmethod
    def _json(settings: typing.Mapping[str, typing.Any]) -> bytes:
        if not isinstance(settings, typing.Mapping):
            raise BadArgument(f"these settings are no JSON object: {type(settings).__name__}")
        try:
            return json.dumps(_nested(settings), allow_nan=False).encode()
        except (TypeError, ValueError) as error:
            raise BadArgument(f"these settings are no JSON object: {error}") from None

    def _request(self, operation: int, document: int = Document.ACTIVE, text: bytes | None = None) -> Answer:
        space = ctypes.create_string_buffer(1 << 16)
        raw = c.Answer(struct_size=ctypes.sizeof(c.Answer))
        with self._use() as handle:
            status = c.library.stof_settings(handle, operation, document, text, space, len(space), raw)
            if status == _TOO_SMALL:
                space = ctypes.create_string_buffer(raw.text_length + 1)
                status = c.library.stof_settings(handle, operation, document, text, space, len(space), raw)
        _check(status, space.value)
        return Answer(raw.revision, bool(raw.restart), c.text(space.value))


def open(address: str | None = None, *, serial: str | None = None, name: str | None = None,  # noqa: A001
         find_timeout: float = 2.5, addresses: typing.Iterable[str] = (), bind: str | None = None, port: int = 0, device_id: int = 0,
         signed_streams: bool = False, keys: str | None = None, key_id: int = 0, max_age_ms: int = 0, socket_buffer: int = 0,
         max_pixels: int = 0, raw: typing.Iterable[str] = (), raw_every: int = 0, recording: str | os.PathLike[str] | None = None,
         pace: float = 0, line: str | None = None, baud: int = 0) -> Sensor:
    """Opens a sensor, a recording or a serial line. Does not wait for it, but may block on a name server.

    address: "HOST" or "HOST:PORT" (7560 without). Instead of it: serial or name, for which discover() looks for `find_timeout`
    seconds, also at `addresses`; or none of them, to wait at `bind` (every IPv4 interface) and `port` (7560) for a sensor that was told to send here.
    device_id: only this one; 0: any. signed_streams: subscribe with a key, and believe only what the sensor signs for this program
    alone (docs/SECURITY.md). keys: file of the keys that requests are signed with, as `stof pair` makes it; None: this user's
    own, "": none. key_id: only the sensor of this key; 0: any. max_age_ms: older frames are dropped and counted; 0: one period
    and 100 ms. socket_buffer: bytes asked of the system; 0: 4 MiB. max_pixels: of one image; 0: 2 Mi. raw: what the cameras gave as well, some of "left", "right" and "pmd", of exposures that have
    all of them, see Sensor.next_raw(); one subscriber at a time has it, of a paired sensor one with signed_streams. raw_every: of so many frames one; 0: each.
    In the place of an address: recording, a file of Sensor.record() or `stof record`; pace: of it, 1: as fast as it was recorded, 2: twice
    as fast, 0: a frame each time that one is asked for. Or line, "/dev/ttyUSB0", a serial line with serial.mode `stof` and serial.profile
    `coarse` or `medium`; baud: of it, 0: 921,600.
    BadArgument, Unreachable, NotFound, NoMemory; FileFailed: no recording.
    """
    if address is not None and (serial is not None or name is not None):
        raise BadArgument("an address and a serial number or name were given: give one of them")
    if address == "":
        raise BadArgument("an empty address: give HOST or HOST:PORT, or None to wait for a sensor that sends here")
    if serial is not None or name is not None:
        found = _find(serial, name, find_timeout, addresses)
        address = found.endpoint
        device_id = device_id or found.device_id
    if not 0 <= pace <= 1000:  # also NaN
        raise BadArgument(f"pace is {pace!r}: takes 0 to 1000")
    most = 2**32 - 1
    names = [raw] if isinstance(raw, str) else list(raw)
    if any(name not in _RAW for name in names):
        raise BadArgument(f"raw is {names!r}: takes some of {', '.join(_RAW)}")
    pictures = sum(_RAW[name] for name in set(names))
    options = c.Options(struct_size=ctypes.sizeof(c.Options), sensor=_encoded(address, "the address"), bind=_encoded(bind, "bind"),
                        port=_integer(port, 65535, "port"), device_id=_integer(device_id, most, "device_id"),
                        signed_streams=bool(signed_streams), keys=_encoded(keys, "keys"), key_id=_integer(key_id, most, "key_id"),
                        max_age_ms=_integer(max_age_ms, most, "max_age_ms"),
                        socket_buffer=_integer(socket_buffer, most, "socket_buffer"),
                        max_pixels=_integer(max_pixels, most, "max_pixels"), raw_pictures=pictures | _RAW_COMPLETE if pictures else 0,
                        raw_every=_integer(raw_every, 65535, "raw_every"),
                        recording=None if recording is None else os.fsencode(recording), line=_encoded(line, "the line"),
                        baud=_integer(baud, most, "baud"), pace_percent=math.ceil(pace * 100))
    handle = ctypes.c_void_p()
    why = ctypes.create_string_buffer(_LINE)
    _check(c.library.stof_open(options, handle, why, len(why)), why.value)
    place = address or line or (f"port {port or 7560}" if recording is None else os.fspath(recording))
    return Sensor(handle, place)
