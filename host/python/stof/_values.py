"""What a sensor tells, as plain values. Numbers that this package does not know (of a newer sensor) stay numbers."""

from __future__ import annotations

import dataclasses
import enum
import typing

from . import _library as c


class Source(enum.IntEnum):
    """Where a depth comes from: pixels of `Frame.source`."""

    NONE = 0
    STEREO = 1
    PMD = 2
    BOTH = 3
    RESOLVED = 4  # no agreement: one sensor, or the surfaces around, decided
    CONFLICT = 5  # they disagreed: no depth


class Cause(enum.IntEnum):
    """Why a depth was resolved or is missing: pixels of `Frame.cause`."""

    NONE = 0
    MIXED_PIXEL = 1
    STEREO_AMBIGUOUS = 2
    RANGE_AMBIGUOUS = 3
    OCCLUDED = 4
    CONTRADICTION = 5
    INTERPOLATED = 6  # no sensor told it, surfaces around did


class HealthState(enum.IntEnum):
    OK = 0
    DEGRADED = 1
    FAULT = 2


class Severity(enum.IntEnum):
    INFO = 0
    MINOR = 1
    MAJOR = 2
    CRITICAL = 3


class Reaction(enum.IntEnum):
    """What the robot should do."""

    NONE = 0
    WATCH = 1  # tell somebody
    SLOW = 2
    STOP = 3


class SensorSet(enum.IntFlag):
    """What a frame stands on."""

    STEREO = 1
    PMD = 2


class FoundBy(enum.IntFlag):
    MDNS = 1
    BEACON = 2
    DIRECTLY = 4  # it answered this machine


class LinkCondition(enum.IntFlag):
    """What is known by this machine's clock, whatever the sensor says."""

    SILENT = 1  # no frame for three periods and 20 ms
    RESTARTED = 2  # for a second, and until the first frame after a start
    FORGED = 4  # in the last 2 s came what no sensor can have sent, or what is not signed and should be; not believed
    DELAYED = 8  # in the last 2 s frames came later than others before by more than max_age_ms; not delivered
    NO_KEY = 16  # of signed streams: whoever answers says that the sensor knows none of your keys


class Document(enum.IntEnum):
    """Which settings."""

    ACTIVE = 0
    STAGED = 1
    SAVED = 2
    DEFAULTS = 3
    SCHEMA = 4  # the JSON Schema of all of these


Enumeration = typing.TypeVar("Enumeration", bound=enum.IntEnum)


def known(kind: type[Enumeration], value: int) -> Enumeration | int:
    try:
        return kind(value)
    except ValueError:
        return value


@dataclasses.dataclass(frozen=True)
class Condition:
    """Something that may be wrong with a sensor."""

    number: int
    name: str  # "stereo_lost"; "unknown" of a newer sensor
    text: str  # a sentence

    def __str__(self) -> str:
        return self.name


def condition_of(number: int) -> Condition:
    return Condition(number, c.text(c.library.stof_condition_name(number)), c.text(c.library.stof_condition_text(number)))


@dataclasses.dataclass(frozen=True)
class Health:
    """What the sensor says of itself, once a second and on change."""

    conditions: tuple[Condition, ...]  # that are active
    severity: Severity | int  # the worst of them
    reaction: Reaction | int
    uptime_s: float
    rate_hz: float  # frames of the last second
    latency_s: float
    longest_latency_s: float
    frames_published: int
    packets_sent: int
    subscribers: int
    settings_revision: int
    age_s: float  # since it arrived here, when it was asked for
    silent: bool  # no frame for three periods and 20 ms: what stands above is of before
    counters: dict[str, int]  # since the sensor's start, by their names in docs/WIRE.md, "Health"

    @classmethod
    def of(cls, raw: c.Health) -> Health:
        return cls(tuple(condition_of(bit) for bit in range(32) if raw.active >> bit & 1), known(Severity, raw.severity),
                   known(Reaction, raw.reaction), raw.uptime_ms / 1000, raw.rate_hz, raw.latency_s, raw.longest_latency_s,
                   raw.frames_published, raw.packets_sent, raw.subscribers, raw.settings_revision, raw.age_ns * 1e-9, bool(raw.silent),
                   {name: getattr(raw, name) for name in c.HEALTH_COUNTERS})


@dataclasses.dataclass(frozen=True)
class Event:
    """A condition that began or ended."""

    sequence: int
    condition: Condition
    severity: Severity | int
    reaction: Reaction | int
    active: bool  # it began; else it ended
    count: int  # how often it has begun
    value: int  # depends on the condition
    at_ns: int  # the sensor's clock

    @classmethod
    def of(cls, raw: c.Event) -> Event:
        return cls(raw.sequence, condition_of(raw.condition), known(Severity, raw.severity), known(Reaction, raw.reaction),
                   bool(raw.active), raw.count, raw.value, raw.at_ns)


@dataclasses.dataclass(frozen=True)
class Link:
    """The state of the link now. Ages in seconds since the newest arrived here; None: there was none."""

    conditions: LinkCondition
    frame_age_s: float | None
    health_age_s: float | None
    calibration_age_s: float | None
    restarts: int  # of the sensor since open()

    @classmethod
    def of(cls, raw: c.Link) -> Link:
        ages = (None if age < 0 else age * 1e-9 for age in (raw.frame_age_ns, raw.health_age_ns, raw.calibration_age_ns))
        return cls(LinkCondition(raw.conditions), *ages, raw.restarts)


@dataclasses.dataclass(frozen=True)
class LinkEvent:
    """A condition of the link that began or ended; a restart (LinkCondition.RESTARTED) begins, and that is all."""

    condition: LinkCondition
    active: bool  # it began; else it ended
    count: int  # how often it has begun
    at_ns: int  # time.monotonic_ns() of this machine

    @classmethod
    def of(cls, raw: c.LinkEvent) -> LinkEvent:
        return cls(LinkCondition(raw.condition), bool(raw.active), raw.count, raw.at_ns)


@dataclasses.dataclass(frozen=True)
class Recorded:
    """A recording that is being written, or was."""

    recording: bool  # it goes on
    frames: int  # handed to the disk; at the end: in the file
    frames_dropped: int  # the disk was too slow for them
    bytes: int  # of the file, at the end; before it 0
    failed: bool  # the disk took no more; what was whole before is kept
    indexed: bool  # at the end; False: `stof recover` makes the index

    @classmethod
    def of(cls, raw: c.Recorded) -> Recorded:
        return cls(raw.recording != 0, raw.frames, raw.frames_dropped, raw.bytes, raw.failed != 0, raw.indexed != 0)


@dataclasses.dataclass(frozen=True)
class Clock:
    """From the sensor's clock to time.monotonic_ns() of this machine: here = sensor + offset_ns."""

    offset_ns: int  # too large by the way of the quickest packet of the last seconds, which nobody knows
    spread_ns: int  # by how much the ways of packets differed
    age_s: float  # of the newest frame that it was made of

    @classmethod
    def of(cls, raw: c.Clock) -> Clock:
        return cls(raw.offset_ns, raw.spread_ns, raw.age_ns * 1e-9)


@dataclasses.dataclass(frozen=True)
class Setting:
    """A setting and what this sensor takes for it; the installer's limits may allow less."""

    value: int | bool | str
    minimum: int | None  # of whole numbers; of texts the least bytes
    maximum: int | None
    default: int | bool | str | None  # None: of a text, which Sensor.get(Document.DEFAULTS) tells
    choices: tuple[str, ...]  # empty: it is none of some words
    unit: str
    at_restart: bool  # a change is in force after the next start, where it was saved

    @classmethod
    def of(cls, raw: c.Setting) -> Setting:
        text, unit, choices = c.text(raw.text), c.text(raw.unit), tuple(c.text(raw.choices).split())
        restart = bool(raw.at_restart)
        if raw.kind == 0:
            return cls(raw.value, raw.minimum, raw.maximum, raw.default_value, (), unit, restart)
        if raw.kind == 1:
            return cls(bool(raw.value), None, None, bool(raw.default_value), (), unit, restart)
        if raw.kind == 2:
            return cls(text, None, None, choices[raw.default_value] if 0 <= raw.default_value < len(choices) else None, choices, unit, restart)
        return cls(text, raw.minimum, raw.maximum, None, (), unit, restart)


@dataclasses.dataclass(frozen=True)
class Calibration:
    """Of the rectified left camera: no distortion, the centre of the first pixel is (0, 0). The point of pixel (u, v) with depth
    Z is X = (u - cx) Z / fx, Y = (v - cy) Z / fy: x right, y down, z forward. Z = fx baseline_m / (disparity + doff)."""

    width: int  # pixels
    height: int
    fx: float  # pixels, as fy, cx, cy, doff
    fy: float
    cx: float
    cy: float
    doff: float  # cx of the right camera less that of the left
    k: tuple[float, ...]  # 9: [fx 0 cx; 0 fy cy; 0 0 1], row by row
    baseline_m: float
    depth_unit_m: float  # of one step of depth and interval_width
    max_range_m: float
    period_s: float  # of the trigger
    pmd_width: int  # 0: no PMD camera
    pmd_height: int
    modulation_hz: float
    r: tuple[float, ...]  # 9: X_left = R X_pmd + T, row by row
    t: tuple[float, ...]  # 3, metres

    @classmethod
    def of(cls, raw: c.Calibration) -> Calibration:
        arrays = ("k", "r", "t")
        return cls(**{field.name: tuple(getattr(raw, field.name)) if field.name in arrays else getattr(raw, field.name)
                      for field in dataclasses.fields(cls)})


@dataclasses.dataclass(frozen=True)
class Info:
    """How a frame was made. Times by the sensor's clock; the exposure is that of the pair, or of the PMD camera where that is alone."""

    exposure_begin_ns: int
    exposure_end_ns: int
    pmd_age_ns: int  # how much older the PMD data are than the pair's
    compute_ns: int
    latency_ns: int  # from the middle of the exposure to the sending of the first packet
    pixels_by_source: tuple[int, ...]  # 6, by Source
    pixels_by_cause: tuple[int, ...]  # 6, by Cause
    settings_revision: int
    pmd_present: bool
    cloud_step: int  # side of a cloud's block, pixels; 0: no cloud
    sensors: SensorSet

    @classmethod
    def of(cls, raw: c.Info) -> Info:
        return cls(raw.exposure_begin_ns, raw.exposure_end_ns, raw.pmd_age_ns, raw.compute_ns, raw.latency_ns,
                   tuple(raw.pixels_by_source), tuple(raw.pixels_by_cause), raw.settings_revision, bool(raw.pmd_present),
                   raw.cloud_step, SensorSet(raw.sensors))


@dataclasses.dataclass(frozen=True)
class Answer:
    """Of a change of settings."""

    revision: int  # of the active settings: advances with every change
    restart: bool  # some of them wait for the next start
    text: str


@dataclasses.dataclass(frozen=True)
class Found:
    """A sensor that was found."""

    serial: str
    name: str
    version: str
    board: str
    endpoint: str  # "192.168.1.20:7560", for open()
    device_id: int
    found_by: FoundBy
    health: HealthState | int | None  # None: unknown, as the rest is then
    rate_hz: float
    subscribers: int
    most_subscribers: int

    @classmethod
    def of(cls, raw: c.Found) -> Found:
        return cls(c.text(raw.serial), c.text(raw.name), c.text(raw.version), c.text(raw.board), c.text(raw.endpoint), raw.device_id,
                   FoundBy(raw.found_by), None if raw.health < 0 else known(HealthState, raw.health), raw.rate_hz, raw.subscribers,
                   raw.most_subscribers)
