"""A frame, and its images as numpy arrays over the library's memory."""

from __future__ import annotations

import collections
import ctypes
import functools
import typing

from . import _library as c
from ._errors import BadArgument, Error, NotYet, error_of
from ._values import Calibration, HealthState, Info, known

if typing.TYPE_CHECKING:
    import numpy

STREAMS = ("depth", "interval_width", "source", "cause", "disparity", "left", "right", "cloud")
_SPARE = 3
_OK, _NOT_YET, _TOO_SMALL = 0, 5, 7


def _numpy() -> typing.Any:
    try:
        import numpy
    except ImportError:
        raise Error("stof: images are numpy arrays and numpy is not installed: install python3-numpy, or pip install numpy") from None
    return numpy


# Types are made once: ctypes makes a new one each time that nobody holds it.
@functools.lru_cache(maxsize=64)
def _bytes(count: int) -> type[ctypes.Array[ctypes.c_uint8]]:
    return ctypes.c_uint8 * count


class Pool:
    """Memory of frames that ended, for the next ones. Any thread may give: deque's operations are whole."""

    def __init__(self) -> None:
        self._spare: collections.deque[int] = collections.deque()
        self._closed = False

    def take(self) -> int | None:
        try:
            return self._spare.pop()
        except IndexError:
            return None

    def give(self, kept: int) -> None:
        self._spare.append(kept)
        if self._closed or len(self._spare) > _SPARE:
            self._release_one()

    def close(self) -> None:
        self._closed = True
        while self._release_one():
            pass

    def _release_one(self) -> bool:
        kept = self.take()
        if kept is not None:
            c.library.stof_release(kept)
        return kept is not None


class _Memory:
    """The images of one frame. Each array and each Frame holds it; the last one gives it back."""

    __slots__ = ("_kept", "_pool")

    def __init__(self, kept: int, pool: Pool) -> None:
        self._kept = kept
        self._pool = pool

    def __del__(self) -> None:
        self._pool.give(self._kept)


class Frame:
    """One frame as it arrived. What did not arrive is 0, counted and marked; nothing is filled in.

    Images are read-only numpy arrays over the memory that the library wrote, without a copy. A frame owns that memory, and so
    does each array and each view of an array: it is valid, and does not change, as long as any of them is held, also after the
    next frame came and after the sensor was closed. `.copy()` is needed to write, or to keep a small part without the whole.
    An image is None where the stream is not sent, or nothing of it arrived.
    """

    __slots__ = ("_raw", "_memory")

    def __init__(self, raw: c.Frame, kept: int, pool: Pool) -> None:
        self._raw = raw
        self._memory = _Memory(kept, pool)

    def __repr__(self) -> str:
        depth = self._raw.depth
        return f"<stof.Frame {self.number}: {depth.width}x{depth.height}, {self.missing_packets} packets missing>"

    @property
    def device_id(self) -> int:
        return self._raw.device_id

    @property
    def session_id(self) -> int:
        """Another one at each start of the sensor."""
        return self._raw.session_id

    @property
    def number(self) -> int:
        """Advances by one with each frame sent, and wraps after 2**32 - 1."""
        return self._raw.number

    @property
    def freshness(self) -> int:
        """Advances with each verified new exposure."""
        return self._raw.freshness

    @property
    def health(self) -> HealthState | int:
        return known(HealthState, self._raw.health)

    @property
    def exposure_middle_ns(self) -> int:
        """By the sensor's clock."""
        return self._raw.exposure_middle_ns

    @property
    def exposure_here_ns(self) -> int | None:
        """The same by CLOCK_MONOTONIC of this machine, time.monotonic_ns(), as Sensor.clock() maps it; None: unknown."""
        return self._raw.exposure_here_ns or None

    @property
    def first_packet_ns(self) -> int:
        """CLOCK_MONOTONIC of this machine: time.monotonic_ns()."""
        return self._raw.first_packet_ns

    @property
    def last_packet_ns(self) -> int:
        """CLOCK_MONOTONIC of this machine: time.monotonic_ns()."""
        return self._raw.last_packet_ns

    @property
    def packets(self) -> int:
        """That the frame was sent in."""
        return self._raw.packets

    @property
    def missing_packets(self) -> int:
        return self._raw.missing_packets

    @property
    def recovered_packets(self) -> int:
        """Made of parity."""
        return self._raw.recovered_packets

    @property
    def complete(self) -> bool:
        return self._raw.missing_packets == 0

    @property
    def emulated(self) -> bool:
        """The sensor's clock is that of an emulated rig."""
        return self._raw.emulated == 1

    @property
    def recorded(self) -> bool:
        """The frame is of a recording that is played again: nothing of it is new."""
        return self._raw.emulated == 2

    @property
    def recorded_ns(self) -> int | None:
        """When the frame of a recording was recorded, ns since 1970; None: it is of a sensor."""
        return self._raw.recorded_ns or None

    @property
    def settings_fingerprint(self) -> int:
        """Of the settings it was made with: another one, other settings. 0: unknown."""
        return self._raw.settings_fingerprint

    @property
    def calibration_fingerprint(self) -> int:
        """Of the calibration it was made with: another one, another calibration on the sensor. 0: unknown."""
        return self._raw.calibration_fingerprint

    @property
    def steady_frames(self) -> int:
        """On how many frames in a row this depth stands, itself included. 0: nobody says."""
        return self._raw.steady_frames

    @property
    def info(self) -> Info | None:
        return Info.of(self._raw.info) if self._raw.has_info else None

    @property
    def calibration(self) -> Calibration | None:
        """What this frame was made with; None until the sensor has told it (once a second)."""
        return Calibration.of(self._raw.calibration) if self._raw.has_calibration else None

    @property
    def depth(self) -> numpy.ndarray | None:
        """(height, width) uint16: Z in the rectified left camera, in steps of calibration.depth_unit_m (0.25 mm); 0: none."""
        return self._image(self._raw.depth, "u2")

    @property
    def interval_width(self) -> numpy.ndarray | None:
        """(height, width) uint16, as depth: the truth lies in depth -+ interval_width / 2 (95 %)."""
        return self._image(self._raw.interval_width, "u2")

    @property
    def source(self) -> numpy.ndarray | None:
        """(height, width) uint8: Source."""
        return self._image(self._raw.source, "u1")

    @property
    def cause(self) -> numpy.ndarray | None:
        """(height, width) uint8: Cause."""
        return self._image(self._raw.cause, "u1")

    @property
    def disparity(self) -> numpy.ndarray | None:
        """(height, width) int16: 1/16 pixel, of the pair alone; -32768: none."""
        return self._image(self._raw.disparity, "i2")

    @property
    def pmd(self) -> tuple[numpy.ndarray | None, ...]:
        """Four times (pmd_height, pmd_width) uint16: the samples A0 to A3 as the PMD camera gave them."""
        return tuple(self._image(plane, "u2") for plane in self._raw.pmd)

    @property
    def left(self) -> numpy.ndarray | None:
        """(height, width) uint8: the left picture, grey, rectified where the sensor rectifies."""
        return self._image(self._raw.left, "u1")

    @property
    def right(self) -> numpy.ndarray | None:
        """(height, width) uint8: the right picture, likewise."""
        return self._image(self._raw.right, "u1")

    @property
    def cloud(self) -> numpy.ndarray | None:
        """(height / step, width / step), a point for each block of info.cloud_step pixels: fields x_mm and y_mm (int16), depth
        and interval_width (uint16, as the images); depth 0: no point."""
        return self._image(self._raw.cloud, [("x_mm", "i2"), ("y_mm", "i2"), ("depth", "u2"), ("interval_width", "u2")])

    def depth_m(self) -> numpy.ndarray | None:
        """(height, width) float32, metres, NaN where there is no depth: a new array. NotYet: no calibration yet."""
        depth = self.depth
        if depth is None:
            return None
        if not self._raw.has_calibration:
            raise NotYet("the unit of depth is not known: no calibration came yet, one comes each second")
        numpy = _numpy()
        metres = depth * numpy.float32(self._raw.calibration.depth_unit_m)
        metres[depth == 0] = numpy.nan
        return metres

    def points(self) -> numpy.ndarray:
        """(n,) of the pixels that have a depth (or of `cloud`, where depth is not sent): fields x, y, z and z_width (float32,
        metres in the rectified left camera: x right, y down, z forward; the truth lies in z -+ z_width / 2, -1: unknown) and
        source (uint32, Source; 0: unknown). A new array. NotYet: no calibration yet. From any thread."""
        raw = self._raw
        most = raw.depth.width * raw.depth.height or raw.cloud.width * raw.cloud.height
        return self._points(c.library.stof_points, most, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("z_width", "f4"), ("source", "u4")])

    def pixel_points(self) -> numpy.ndarray:
        """The same of `depth` alone, with the pixel of each: fields x, y, z, z_width, u and v (uint16: column and row), source, cause,
        grey (uint8, of the left picture there) and has_grey (uint8, 0: it is not sent, or did not arrive there). A new array. NotYet:
        no calibration yet; Unsupported: depth is not sent. From any thread."""
        raw = self._raw
        return self._points(c.library.stof_pixel_points, raw.depth.width * raw.depth.height,
                            [("x", "f4"), ("y", "f4"), ("z", "f4"), ("z_width", "f4"), ("u", "u2"), ("v", "u2"), ("source", "u1"), ("cause", "u1"),
                             ("grey", "u1"), ("has_grey", "u1")])

    def _points(self, make: typing.Any, most: int, fields: list[tuple[str, str]]) -> numpy.ndarray:
        numpy = _numpy()
        count = ctypes.c_size_t(most)
        while True:
            points = numpy.empty(count.value, numpy.dtype(fields))
            status = make(self._raw, points.ctypes.data, points.size, count)
            if status != _TOO_SMALL:
                break
        if status != _OK:
            text = "points take a calibration: none came yet, one comes each second" if status == _NOT_YET else c.text(
                c.library.stof_status_text(status))
            raise error_of(status, text)
        return points[:count.value]

    def missing(self, stream: str) -> int:
        """Pixels of an image that did not arrive: "depth", ..., "pmd0" to "pmd3"."""
        return self._plane(stream).missing

    def arrived(self, stream: str) -> numpy.ndarray | None:
        """(height, width) bool: which pixels of an image arrived; a new array. None: as the image."""
        plane = self._plane(stream)
        if not plane.data:
            return None
        numpy = _numpy()
        if not plane.marks:
            return numpy.full((plane.height, plane.width), plane.missing == 0)
        marks = self._array(plane.marks, (plane.height, plane.width), plane.marks_stride, numpy.dtype("u1"))
        return (marks & plane.mark) != 0

    def _plane(self, stream: str) -> c.Plane:
        if stream in STREAMS:
            return getattr(self._raw, stream)
        if stream in ("pmd0", "pmd1", "pmd2", "pmd3"):
            return self._raw.pmd[int(stream[3:])]
        raise BadArgument(f"'{stream}' is no image: use one of {', '.join(STREAMS)}, pmd0 to pmd3")

    def _image(self, plane: c.Plane, kind: typing.Any) -> numpy.ndarray | None:
        if not plane.data:
            return None
        return self._array(plane.data, (plane.height, plane.width), plane.stride, _numpy().dtype(kind))

    def _array(self, address: int, shape: tuple[int, int], stride: int, kind: numpy.dtype) -> numpy.ndarray:
        height, width = shape
        memory = _bytes((height - 1) * stride + width * kind.itemsize).from_address(address)
        memory.owner = self._memory  # each array holds `memory`
        numpy = _numpy()
        # By frombuffer, whose base is the read-only view: nobody can make it writable.
        return numpy.ndarray(shape, kind, numpy.frombuffer(memoryview(memory).toreadonly(), "u1"), strides=(stride, kind.itemsize))


class Raw:
    """What the cameras gave for one exposure, before rectification, bit for bit: open(raw=...). A picture is a numpy array of its
    own, or None where it was not sent or missed a packet."""

    __slots__ = ("device_id", "session_id", "frame_number", "freshness", "number", "dropped", "edge_ns", "exposure_middle_ns", "state", "complete",
                 "left", "right", "pmd")

    def __init__(self, raw: c.Raw) -> None:
        self.device_id: int = raw.device_id
        self.session_id: int = raw.session_id
        self.frame_number: int = raw.frame_number  # of the frame that was computed from it
        self.freshness: int = raw.freshness  # of that frame: the exposure's id
        self.number: int = raw.number  # from 1, of this request
        self.dropped: int = raw.dropped  # exposures that the sensor had no time for
        self.edge_ns: int = raw.edge_ns  # by the sensor's clock, as the next one
        self.exposure_middle_ns: int = raw.exposure_middle_ns
        self.state: int = raw.state  # docs/WIRE.md, "raw_info"
        self.complete: bool = raw.missing == 0
        self.left: numpy.ndarray | None = self._picture(raw.left, "u1")  # (height, width)
        self.right: numpy.ndarray | None = self._picture(raw.right, "u1")
        self.pmd: tuple[numpy.ndarray | None, ...] = tuple(self._picture(plane, "u2") for plane in raw.pmd)  # A0 to A3

    def __repr__(self) -> str:
        return f"<stof.Raw {self.number} of frame {self.frame_number}{'' if self.complete else ', incomplete'}>"

    @staticmethod
    def _picture(plane: c.Plane, kind: str) -> numpy.ndarray | None:
        if not plane.data:
            return None
        numpy = _numpy()
        rows = numpy.frombuffer(ctypes.string_at(plane.data, plane.bytes), numpy.uint8)
        shape, strides = (plane.height, plane.width), (plane.stride, numpy.dtype(kind).itemsize)
        return numpy.ndarray(shape, numpy.dtype(kind), rows, 0, strides).copy()
