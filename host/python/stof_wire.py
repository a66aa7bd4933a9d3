"""The wire of a stof sensor: packets to objects and back. Plain Python 3, nothing to install.

header, payload = parse(datagram)        # raises Refused, whose text is the cause
message = MESSAGES[header.type].unpack(payload)  # types that have a message; raises Refused
datagram = seal(Header(type=PacketType.DISCOVER), Discover(request_id=1).pack())

The bytes are those of docs/WIRE.md. Numbers of the enumerations may be unknown: of a newer sensor.
"""

import dataclasses
import enum
import struct
import typing

MAX_DATAGRAM = 1232
CRC_BYTES = 4


class Refused(Exception):
    """Bytes that are not what they should be; the text is the cause."""


# made: enumerations (by scripts/wire_table.py, of firmware/wire/messages.json: change that)
class PacketType(enum.IntEnum):
    TILE = 1  # part of a frame: a run of pixels of one stream
    FRAME_INFO = 2  # part of a frame: its index 0
    CALIBRATION = 64  # once a second, with the number of the frame it was sent beside; index 0 of 1
    HEALTH = 65  # once a second and on change, also without frames; index 0 of 1
    PARITY = 66  # of a frame: its index counts groups; see "Parity"
    # a condition that began or ended, when it did and once more a second later; index 0 of 1
    EVENT = 67
    ANNOUNCE = 68  # who and where the sensor is; answers a discover, and the beacon
    SECTORS = 69  # nearest obstacle by direction; on serial lines; index 0 of 1
    # begins the raw pictures of one exposure: index 0 of them; only to who asked, see "Raw
    # pictures"
    RAW_INFO = 70
    RAW_TILE = 71  # a run of pixels of one of them
    SUBSCRIBE = 128  # to the sensor: send me the streams, and go on for a lease
    SUBSCRIBED = 129  # answer to subscribe and unsubscribe
    UNSUBSCRIBE = 130  # to the sensor: stop
    SETTINGS_REQUEST = 132  # to the sensor: read or change settings
    SETTINGS_ANSWER = 133  # answer to it
    DISCOVER = 134  # to the sensor, also by broadcast: who are you
    SIGNED_REQUEST = 136  # to the sensor: a request that a key signs
    SIGNED_ANSWER = 137  # answer to it, signed with the same key
    PAIR_REQUEST = 138  # to the sensor: make a key that both of us know
    PAIR_ANSWER = 139  # answer to it


class Stream(enum.IntEnum):
    NONE = 0  # outside tiles
    DEPTH = 1  # u16, quarter millimetres, Z in the rectified left camera; 0 = none
    # u16, quarter millimetres, of the interval: the truth lies in depth - width / 2 .. depth +
    # width / 2 (95 percent); 0 where depth is none. A quarter of it is the standard deviation
    WIDTH = 2
    # u8: where the depth comes from (bits 0 to 3, see "Sources") and why it was resolved or is
    # missing (bits 4 to 7, see "Causes")
    SOURCE = 3
    # u16: 32768 + disparity in 1/16 px of the rectified left picture, stereo alone; 0 = none
    DISPARITY = 4
    # u16: the four samples of the PMD camera as they came, A0 to A3 below each other (reference
    # phase 0, 90, 180, 270 degrees): PMD width x 4 PMD height
    PMD_RAW = 5
    GREY_LEFT = 6  # u8: the left picture, rectified where the sensor rectifies
    GREY_RIGHT = 7  # u8: the right picture, likewise
    # one point for each block of step x step pixels: of its pixels with a depth the one whose near
    # bound (depth - width / 2) is nearest
    CLOUD = 8
    # u8: pixels of the left camera as it gave them, in raw tiles only, as the next two
    RAW_LEFT = 16
    RAW_RIGHT = 17  # u8: of the right camera
    RAW_PMD = 18  # u16: the samples of the PMD camera, laid out as pmd raw


class Codec(enum.IntEnum):
    NONE = 0  # outside tiles
    RAW16 = 1  # two bytes a pixel
    RAW8 = 2  # one byte a pixel
    RVL16 = 3  # RVL of values of 16 bits, begun anew in each packet; see "RVL"
    RVL8 = 4  # RVL of values of 8 bits
    # 8 bytes a point: x and y (i16, mm), depth and width (u16, quarter millimetres); depth 0 = no
    # point
    POINTS = 5


class Health(enum.IntEnum):
    OK = 0  # good
    DEGRADED = 1  # a minor or major condition is active
    FAULT = 2  # a critical condition is active


class ClockState(enum.IntEnum):
    MONOTONIC = 0  # nanoseconds of the sensor's own clock, synchronised with nothing
    EMULATED = 1  # an emulated rig's own time
    # of a recording that is played again: the stamps, and what they stamp, are of the past
    RECORDED = 2


class Severity(enum.IntEnum):
    INFO = 0  # nothing to do
    MINOR = 1  # the data are good, something wants attention
    MAJOR = 2  # the data are incomplete or less sure than usual; may heal by itself
    CRITICAL = 3  # there are no data; may heal by itself


class Reaction(enum.IntEnum):
    NONE = 0  # go on
    WATCH = 1  # go on, tell whoever maintains the robot
    SLOW = 2  # slow down: rely on what arrives, but expect gaps
    STOP = 3  # bring the robot to a safe stop: the sensor sees nothing


class SubscribeResult(enum.IntEnum):
    OK = 0  # the streams come, for the lease
    COOKIE = 1  # repeat the request with this cookie
    FULL = 2  # as many subscribers as the sensor takes: try again when one has left
    ENDED = 3  # the subscription is over
    UNKNOWN_KEY = 4  # the signature is of no key that the sensor has; never signed
    STALE = 5  # refused, nothing changed: the counter is not above `highest` of the answer
    # the streams come, for the lease, but no raw pictures: they take a key that this request was
    # not signed with
    RAW_DENIED = 6
    # the streams come, for the lease, but no raw pictures: another subscriber has them. Ask on
    RAW_TAKEN = 7


class SettingsOperation(enum.IntEnum):
    GET = 0  # read a document, from `offset` on
    # the text is a JSON object: changes those fields of the active settings, and nothing if one of
    # them is refused
    SET = 1
    # the same to the staged settings, which are the active ones until something is staged
    STAGE = 2
    COMMIT = 3  # the staged settings become the active ones and are saved
    REVERT = 4  # what is staged is forgotten
    PRESET = 5  # the text is a preset's name: as set, with its fields
    SAVE = 6  # the active settings are those of the next start
    RESET = 7  # as set, with every field's default
    # a JSON array of the keys of the sensor (id, role, name), never of their secrets, read from
    # `offset` on as a document is; for an admin
    KEYS = 8
    # the text is the id of a key, 8 hexadecimal digits: it is none any more; for an admin, or
    # whoever signs with it
    UNPAIR = 9
    # an upload request follows, and a chunk of what is uploaded, see "Uploads"; for an admin
    UPLOAD = 10
    # a download request follows: reads a part of what is longer than a document, see "Downloads"
    DOWNLOAD = 11


class SettingsDocument(enum.IntEnum):
    ACTIVE = 0  # what the sensor runs with
    STAGED = 1  # what commit would make active
    SAVED = 2  # what the next start would use
    DEFAULTS = 3  # what it would run with without any file
    SCHEMA = 4  # the JSON Schema of all of these
    # no settings: {"ipv4": ["192.168.1.20"]}, the addresses that its computer has in this moment
    # but for loopback, eight at most; for an admin or the cable
    NETWORK = 5


class Role(enum.IntEnum):
    NONE = 0  # nobody's
    VIEW = 1  # reads
    TUNE = 2  # changes what SETTINGS.md marks so, within the installer's limits, and saves
    ADMIN = 3  # changes everything, keys and limits too


class PairStep(enum.IntEnum):
    BEGIN = 0  # the client binds itself to its public key and nonce: `value` is its commitment
    REVEAL = 1  # the client shows both: `value` is its public key
    # the client's user is content: `value` begins with the client's tag. Repeat it while the answer
    # is `waiting`
    CONFIRM = 2
    # over a serial line that is no way for strangers: opens the two minutes for others, as the
    # button does. `nonce`: random, of this opening; repeated with it, tells how they stand
    OPEN = 3
    # over such a line: accepts the digits that `value` begins with (u32), as the button does that
    # is held; other digits end the attempt, and 1,000,000 the two minutes also where nobody has
    # come
    ACCEPT = 4


class PairMethod(enum.IntEnum):
    # six digits are compared by people, in the two minutes after the button was pressed, or a cable
    # asked for them
    DIGITS = 0
    CODE = 1  # both know the code of the sensor's label
    CABLE = 2  # over a serial line that is no way for strangers
    KEY = 3  # both know the key `key_id`, which gets a new secret


class PairResult(enum.IntEnum):
    # done; of confirm, and of open and accept with a key id: the key is in force, and kept where
    # the sensor keeps any
    OK = 0
    COOKIE = 1  # repeat the request with this cookie
    # not now, or not in this way: press the button first, or there is no such code or key; of open:
    # the two minutes are over, without a key
    CLOSED = 2
    # somebody else pairs too: with digits both have ended, and the button has to be pressed again;
    # else try again
    BUSY = 3
    # the commitment or the tag does not fit, role or name are none, the secret that was shown is
    # none of the key's any more, or nothing was begun from this address: it has ended
    WRONG = 4
    # of confirm: nobody has accepted the digits at the sensor yet; of open and accept: somebody has
    # come, one of both ends has not agreed yet
    WAITING = 5
    FULL = 6  # the sensor keeps no more keys, or cannot save them
    # this key was renewed, or the code was used, too often for the flash that it wears: ten times
    # follow each other, then one an hour; nothing changed
    LATER = 7


class UploadStep(enum.IntEnum):
    BEGIN = 0  # this is to come; where some of it has come already, the answer says how much
    CHUNK = 1  # its bytes from `offset` on follow
    COMMIT = 2  # all of it is there: judge it, keep it, use it
    # back to what was there before the first upload of this kind: of a calibration the factory's;
    # `total`, `offset` and `hash` are not looked at
    REVERT = 3
    # nothing is done: the answer says what is in force; `total`, `offset` and `hash` are not looked
    # at
    ASK = 4


class UploadKind(enum.IntEnum):
    CALIBRATION = 1  # a calibration file, see "Calibration file"
    UPDATE = 2  # an update file, see "Update file"


class SensorState(enum.IntEnum):
    MEASURING = 0  # frames come as the settings say, or a condition says why not
    # no edges and no light, as the setting `standby` wants: nobody subscribes; the first one who
    # does ends it
    STANDBY = 1


class UploadState(enum.IntEnum):
    SETTLED = 0  # each start uses what is in force
    # of updates: the next start uses what was there before, unless this one is confirmed
    ON_TRIAL = 1
    RESTARTING = 2  # of updates: the sensor is about to restart
    # of updates: as settled; the release in the other slot was to be tried, and was not confirmed
    LEFT = 3


class SettingsResult(enum.IntEnum):
    OK = 0  # done; of get: the text is a part of the document
    COOKIE = 1  # repeat the request with this cookie
    INVALID = 2  # refused, nothing changed; the text says which field and what it takes
    NOT_SAVED = 3  # active, but could not be saved; the text says why
    UNSUPPORTED = 4  # an operation or document this sensor does not know
    BUSY = 5  # another request is being served: repeat
    # refused, nothing changed: it takes a key, or one with another role; the text says which field
    # and what it takes
    DENIED = 6
    UNKNOWN_KEY = 7  # the signature is of no key that the sensor has; never signed
    STALE = 8  # refused, nothing changed: the counter is not above `highest` of the answer


class Condition(enum.IntEnum):
    """What can be wrong with a sensor: values in events, bits in health."""

    NO_FRAMES = 0  # several edges in a row without a frame; value: edges so far
    TRIGGER_LOST = 1  # the trigger line is gone; value: 0
    STEREO_LOST = 2  # a stereo camera is gone; value: 0
    PMD_LOST = 3  # the PMD camera is gone; value: 0
    LATE = 4  # the computer is too slow: periods were skipped; value: periods skipped
    LINK_LOST = 5  # the network port failed; value: 0
    UNREACHABLE = 6  # datagrams do not leave: nobody can be reached; value: 0
    # the network does not take all datagrams: send less, or raise the port's buffer; value:
    # datagrams dropped in this second
    LINK_FULL = 7
    # the rig has drifted from its calibration: calibrate it anew; value: bit k: drift k is
    # significant
    DRIFT = 8
    SERIAL_LOST = 9  # the serial port failed; value: 0
    # the serial line is too slow for its profile and rate; value: frames dropped in this second
    SERIAL_FULL = 10
    SETTINGS_UNSAVED = 11  # the settings could not be saved; value: 0
    RESTART_NEEDED = 12  # some settings wait for the next start; value: 0
    FLOODED = 13  # more than 1,000 refused requests in a second; value: refused in this second
    # settings named what this version has not: these fields are as the preset has them, until the
    # settings are saved; value: 0
    SETTINGS_FELL_BACK = 14
    # the stereo pair is there, but several edges in a row gave no pictures that belong to them;
    # value: 0
    STEREO_SILENT = 15
    # a stereo camera sends its last picture again and again; the pair is opened again at once, then
    # once a second at most; value: the sum of: 1 the left camera, 2 the right one
    STEREO_FROZEN = 16
    # the PMD camera is there, but several edges in a row gave no samples that belong to them;
    # value: 0
    PMD_SILENT = 17
    # the PMD camera sends its last samples again and again; it is opened again at once, then once a
    # second at most; value: 0
    PMD_FROZEN = 18
    # the PMD camera's samples hold no light of its lamp: it is dark, nothing is within its reach,
    # or other light drowns it; value: 0
    PMD_DARK = 19
    # the saved settings could not be used at the start: the last good ones hold, or the defaults,
    # until settings are saved; value: 1 missing, 2 no regular file, 3 unreadable, 4 empty, 5
    # damaged or not for this sensor, 6 two starts with them failed; 16 more where the last good
    # ones hold; 32 more where nobody knows what an installer fixed: the strictest limits hold, and
    # the serial line counts as remote
    SETTINGS_DROPPED = 20
    # a port or line of the settings could not be had at the start: another port or no line is used
    # until the next; value: the sum of: 1 the UDP port, 2 the serial line, which is none of the
    # board's
    CONNECTION_REPLACED = 21
    # frames go out, but the sensor is blind, or its settings blind it; value: the sum of: 1 fewer
    # than 2 percent of the last second's pixels have a depth, 2 no stream and no serial line
    # carries depth, 4 the maximal range is below 1 m
    NO_DEPTH = 22
    # somebody changed the settings in the last ten seconds; each change is an event of its own;
    # value: who: the last four bytes of the address, its first the highest; 4,294,967,295 where
    # these are 0; 0: over the serial line
    SETTINGS_CHANGED = 23
    # no key is known: anybody on the network may change what docs/SECURITY.md calls harmless;
    # value: 0
    UNPAIRED = 24
    # the keys could not be read at the start: nobody on the network may change anything; value: 0
    KEYS_LOST = 25
    # the sensor's button was pressed, or its cable asked for it: whoever accepts the digits with it
    # makes a key; value: 1,000,000 and the six digits that the sensor has; 0: nobody has come yet.
    # Over the network they prove nothing
    PAIRING = 26
    # somebody made, renewed or ended a key in the last ten seconds; each change is an event of its
    # own; value: the key's id
    KEYS_CHANGED = 27
    # the stereo pair is there, but hardly any depth stands on it: too dark or too bright, covered,
    # nothing but bare or repeating surfaces, or settings of depth.match that drop every match;
    # value: 0
    STEREO_BLIND = 28
    # somebody put another calibration on the sensor in the last ten seconds; each change is an
    # event of its own; value: the fingerprint of the new one; `former`: of the one before
    CALIBRATION_CHANGED = 29
    # the installed calibration could not be used at the start: the factory's holds, until one is
    # installed; value: 1 no regular file or unreadable, 2 damaged, of a later version, or not of
    # this rig
    CALIBRATION_DROPPED = 30
    # an update runs on trial: it is confirmed, or the sensor restarts with the former release
    # within two minutes; value: 1 on trial; where it has ended: 2 confirmed, 3 left, which the
    # former release tells from its start on. `former`: the fingerprint of the release
    RELEASE_ON_TRIAL = 31


class ConditionInfo(typing.NamedTuple):
    """What a condition means."""

    text: str
    severity: Severity
    reaction: Reaction  # of the robot while it is active


CONDITIONS = {
    Condition.NO_FRAMES: ConditionInfo(
        "several edges in a row without a frame",
        Severity.CRITICAL, Reaction.STOP),
    Condition.TRIGGER_LOST: ConditionInfo(
        "the trigger line is gone",
        Severity.CRITICAL, Reaction.STOP),
    Condition.STEREO_LOST: ConditionInfo(
        "a stereo camera is gone",
        Severity.MAJOR, Reaction.SLOW),
    Condition.PMD_LOST: ConditionInfo(
        "the PMD camera is gone",
        Severity.MAJOR, Reaction.SLOW),
    Condition.LATE: ConditionInfo(
        "the computer is too slow: periods were skipped",
        Severity.MAJOR, Reaction.SLOW),
    Condition.LINK_LOST: ConditionInfo(
        "the network port failed",
        Severity.MAJOR, Reaction.NONE),
    Condition.UNREACHABLE: ConditionInfo(
        "datagrams do not leave: nobody can be reached",
        Severity.MINOR, Reaction.NONE),
    Condition.LINK_FULL: ConditionInfo(
        "the network does not take all datagrams: send less, or raise the port's buffer",
        Severity.MAJOR, Reaction.SLOW),
    Condition.DRIFT: ConditionInfo(
        "the rig has drifted from its calibration: calibrate it anew",
        Severity.MAJOR, Reaction.WATCH),
    Condition.SERIAL_LOST: ConditionInfo(
        "the serial port failed",
        Severity.MAJOR, Reaction.NONE),
    Condition.SERIAL_FULL: ConditionInfo(
        "the serial line is too slow for its profile and rate",
        Severity.MINOR, Reaction.NONE),
    Condition.SETTINGS_UNSAVED: ConditionInfo(
        "the settings could not be saved",
        Severity.MINOR, Reaction.WATCH),
    Condition.RESTART_NEEDED: ConditionInfo(
        "some settings wait for the next start",
        Severity.INFO, Reaction.NONE),
    Condition.FLOODED: ConditionInfo(
        "more than 1,000 refused requests in a second",
        Severity.MINOR, Reaction.WATCH),
    Condition.SETTINGS_FELL_BACK: ConditionInfo(
        "settings named what this version has not: these fields are as the preset has them, until the settings are saved",
        Severity.MINOR, Reaction.WATCH),
    Condition.STEREO_SILENT: ConditionInfo(
        "the stereo pair is there, but several edges in a row gave no pictures that belong to them",
        Severity.MAJOR, Reaction.SLOW),
    Condition.STEREO_FROZEN: ConditionInfo(
        "a stereo camera sends its last picture again and again; the pair is opened again at once, then once a second at most",
        Severity.MAJOR, Reaction.SLOW),
    Condition.PMD_SILENT: ConditionInfo(
        "the PMD camera is there, but several edges in a row gave no samples that belong to them",
        Severity.MAJOR, Reaction.SLOW),
    Condition.PMD_FROZEN: ConditionInfo(
        "the PMD camera sends its last samples again and again; it is opened again at once, then once a second at most",
        Severity.MAJOR, Reaction.SLOW),
    Condition.PMD_DARK: ConditionInfo(
        "the PMD camera's samples hold no light of its lamp: it is dark, nothing is within its reach, or other light drowns it",
        Severity.MAJOR, Reaction.SLOW),
    Condition.SETTINGS_DROPPED: ConditionInfo(
        "the saved settings could not be used at the start: the last good ones hold, or the defaults, until settings are saved",
        Severity.MINOR, Reaction.WATCH),
    Condition.CONNECTION_REPLACED: ConditionInfo(
        "a port or line of the settings could not be had at the start: another port or no line is used until the next",
        Severity.MINOR, Reaction.WATCH),
    Condition.NO_DEPTH: ConditionInfo(
        "frames go out, but the sensor is blind, or its settings blind it",
        Severity.CRITICAL, Reaction.STOP),
    Condition.SETTINGS_CHANGED: ConditionInfo(
        "somebody changed the settings in the last ten seconds; each change is an event of its own",
        Severity.INFO, Reaction.WATCH),
    Condition.UNPAIRED: ConditionInfo(
        "no key is known: anybody on the network may change what docs/SECURITY.md calls harmless",
        Severity.INFO, Reaction.NONE),
    Condition.KEYS_LOST: ConditionInfo(
        "the keys could not be read at the start: nobody on the network may change anything",
        Severity.MINOR, Reaction.WATCH),
    Condition.PAIRING: ConditionInfo(
        "the sensor's button was pressed, or its cable asked for it: whoever accepts the digits with it makes a key",
        Severity.INFO, Reaction.NONE),
    Condition.KEYS_CHANGED: ConditionInfo(
        "somebody made, renewed or ended a key in the last ten seconds; each change is an event of its own",
        Severity.INFO, Reaction.WATCH),
    Condition.STEREO_BLIND: ConditionInfo(
        "the stereo pair is there, but hardly any depth stands on it: too dark or too bright, covered, nothing but bare or repeating surfaces, or settings of depth.match that drop every match",
        Severity.MAJOR, Reaction.SLOW),
    Condition.CALIBRATION_CHANGED: ConditionInfo(
        "somebody put another calibration on the sensor in the last ten seconds; each change is an event of its own",
        Severity.INFO, Reaction.WATCH),
    Condition.CALIBRATION_DROPPED: ConditionInfo(
        "the installed calibration could not be used at the start: the factory's holds, until one is installed",
        Severity.MINOR, Reaction.WATCH),
    Condition.RELEASE_ON_TRIAL: ConditionInfo(
        "an update runs on trial: it is confirmed, or the sensor restarts with the former release within two minutes",
        Severity.INFO, Reaction.WATCH),
}
# made: end


class Layout:
    """Fields one after the other, without gaps. LAYOUT: (name, code of struct, or class, count)."""

    LAYOUT: typing.ClassVar[tuple] = ()

    @classmethod
    def size(cls):
        """Bytes."""
        return sum(count * (struct.calcsize("<" + kind) if isinstance(kind, str) else kind.size())
                   for _, kind, count in cls.LAYOUT)

    @classmethod
    def unpack(cls, data, at=0):
        """From the bytes that begin at `at`; what follows them is ignored. Raises Refused."""
        if len(data) - at < cls.size():
            raise Refused("truncated")
        found = {}
        for name, kind, count in cls.LAYOUT:
            values = []
            for _ in range(count):
                if isinstance(kind, str):
                    values += struct.unpack_from("<" + kind, data, at)
                    at += struct.calcsize("<" + kind)
                else:
                    values.append(kind.unpack(data, at))
                    at += kind.size()
            if name:
                found[name] = cls._value(name, values)
        return cls(**found)

    @classmethod
    def _value(cls, name, values):
        kind = cls.__dataclass_fields__[name].type
        if kind is str:
            return bytes(values).split(b"\0")[0].decode("utf-8", "replace")
        return tuple(values) if kind is tuple else values[0]

    def pack(self):
        """Bytes. Raises struct.error where a number does not fit its field."""
        out = bytearray()
        for name, kind, count in self.LAYOUT:
            value = getattr(self, name) if name else None
            if kind == "x":
                out += bytes(count)
            elif isinstance(value, str):
                out += value.encode()[:count].ljust(count, b"\0")
            else:
                values = value if isinstance(value, tuple) else (value,)
                if len(values) != count:
                    raise struct.error(f"{name}: takes {count} values, not {len(values)}")
                for one in values:
                    out += struct.pack("<" + kind, one) if isinstance(kind, str) else one.pack()
        return bytes(out)


# made: messages (by scripts/wire_table.py, of firmware/wire/messages.json: change that)
@dataclasses.dataclass
class RawRequest(Layout):
    # raw pictures that are asked for, the sum of: 1 the left camera's, 2 the right one's, 4 the PMD
    # camera's samples; 8: only exposures that have all of these; 16: the sensor begins anew all
    # that counts from frame to frame. 0: none; see "Raw pictures"
    pictures: int = 0
    step: int = 0  # of the pair: one column and one row of so many is sent; 0: each, as 1
    every: int = 0  # one exposure of so many frames, the next that there is; 0: each, as 1
    column: int = 0  # of the pair: first column of the part that is sent, pixels of the camera
    row: int = 0  # first row
    width: int = 0  # columns of it; 0: all that follow
    height: int = 0  # rows; 0: all that follow

    LAYOUT: typing.ClassVar[tuple] = (
        ("pictures", "B", 1),
        ("step", "B", 1),
        ("every", "H", 1),
        ("column", "H", 1),
        ("row", "H", 1),
        ("width", "H", 1),
        ("height", "H", 1),
    )


@dataclasses.dataclass
class Window(Layout):
    begin_ns: int = 0  # begin, ns
    end_ns: int = 0  # end, ns

    LAYOUT: typing.ClassVar[tuple] = (
        ("begin_ns", "q", 1),
        ("end_ns", "q", 1),
    )


@dataclasses.dataclass
class Origin(Layout):
    device_id: int = 0  # of the sensor; in requests the one that is meant, 0: any
    session_id: int = 0  # random, another one at each start of the sender; in requests ignored

    LAYOUT: typing.ClassVar[tuple] = (
        ("device_id", "I", 1),
        ("session_id", "I", 1),
    )


@dataclasses.dataclass
class LoopCounters(Layout):
    edges: int = 0  # trigger edges since the sender's start, as all counters that follow
    frames_published: int = 0  # frames published
    mispaired: int = 0  # exposures that did not belong to one edge, not published
    timeouts: int = 0  # of cameras
    deadline_misses: int = 0  # periods skipped and frames too old to publish
    link_drops: int = 0  # datagrams that the link did not take

    LAYOUT: typing.ClassVar[tuple] = (
        ("edges", "Q", 1),
        ("frames_published", "Q", 1),
        ("mispaired", "Q", 1),
        ("timeouts", "Q", 1),
        ("deadline_misses", "Q", 1),
        ("link_drops", "Q", 1),
    )


@dataclasses.dataclass
class DriftReading(Layout):
    value: int = 0  # see "Drift" for the unit
    sigma: int = 2147483647  # standard deviation; 2^31 - 1: unknown

    LAYOUT: typing.ClassVar[tuple] = (
        ("value", "i", 1),
        ("sigma", "i", 1),
    )


@dataclasses.dataclass
class ControlCounters(Layout):
    accepted: int = 0  # requests that were served, since the sender's start, as all that follow
    truncated: int = 0  # refused: cut short
    bad_magic: int = 0  # refused: not a packet of ours
    bad_version: int = 0  # refused: of another version
    bad_length: int = 0  # refused: longer than it says
    bad_crc: int = 0  # refused: damaged
    bad_field: int = 0  # refused: contradicts itself
    not_control: int = 0  # refused: of a type that a sensor does not take
    foreign: int = 0  # refused: for another device
    # refused: shorter than its answer could be, from a source that was not validated
    too_short: int = 0
    cookies: int = 0  # answered with a cookie only: the source was not validated
    busy: int = 0  # refused: more requests at once than the sensor queues
    overrun: int = 0  # lost before they were read: the socket's buffer was full
    forged: int = 0  # refused: signed with no key that is known here
    replayed: int = 0  # refused: signed, but its counter is no higher than one before

    LAYOUT: typing.ClassVar[tuple] = (
        ("accepted", "Q", 1),
        ("truncated", "Q", 1),
        ("bad_magic", "Q", 1),
        ("bad_version", "Q", 1),
        ("bad_length", "Q", 1),
        ("bad_crc", "Q", 1),
        ("bad_field", "Q", 1),
        ("not_control", "Q", 1),
        ("foreign", "Q", 1),
        ("too_short", "Q", 1),
        ("cookies", "Q", 1),
        ("busy", "Q", 1),
        ("overrun", "Q", 1),
        ("forged", "Q", 1),
        ("replayed", "Q", 1),
    )


@dataclasses.dataclass
class Header(Layout):
    """Of every packet, before its payload."""

    magic: int = 0x464f5453  # `53 54 4f 46`, "STOF"
    version: int = 1  # 1. A receiver refuses every other value
    type: int = 0  # PacketType: see "Types"
    # H, offset of the payload: 52 in this version. A larger one is legal: skip what lies between 52
    # and H
    header_length: int = 52
    # bits 0 to 3: scale of a tile of depth or width (see "Tiles"), else 0. Bit 4: a tile of source
    # is told in steps. Bits 5 to 7 are reserved
    flags: int = 0
    origin: Origin = dataclasses.field(default_factory=Origin)
    stream: int = 0  # Stream: see "Streams"; 0 outside tiles
    codec: int = 0  # Codec: see "Streams"; 0 outside tiles
    health: int = 0  # Health: summary of the sensor: 0 good, 1 degraded, 2 fault
    # ClockState: what times count from: 0 the sensor's own monotonic clock, synchronised with
    # nothing; 1 the time of an emulated rig
    clock: int = 0
    number: int = 0  # of the frame: advances by one with each frame sent, wraps from 2^32 - 1 to 0
    # ns: middle of the exposure of the stereo pair; of the PMD camera in a frame of it alone
    exposure_middle_ns: int = 0
    freshness: int = 0  # see "Freshness"
    index: int = 0  # of the packet, from 0, below the count
    count: int = 1  # packets of the frame, at least 1
    # pixels, of the whole image of the stream; outside tiles of the depth image
    image_width: int = 0
    image_height: int = 0  # rows, likewise
    first_row: int = 0  # of a tile; 0 in other types, as the next two
    first_column: int = 0  # of a tile
    pixel_count: int = 0  # of a tile
    payload_length: int = 0  # P

    LAYOUT: typing.ClassVar[tuple] = (
        ("magic", "I", 1),
        ("version", "B", 1),
        ("type", "B", 1),
        ("header_length", "B", 1),
        ("flags", "B", 1),
        ("origin", Origin, 1),
        ("stream", "B", 1),
        ("codec", "B", 1),
        ("health", "B", 1),
        ("clock", "B", 1),
        ("number", "I", 1),
        ("exposure_middle_ns", "q", 1),
        ("freshness", "I", 1),
        ("index", "H", 1),
        ("count", "H", 1),
        ("image_width", "H", 1),
        ("image_height", "H", 1),
        ("first_row", "H", 1),
        ("first_column", "H", 1),
        ("pixel_count", "H", 1),
        ("payload_length", "H", 1),
    )


@dataclasses.dataclass
class FrameInfo(Layout):
    """Type 2, one a frame."""

    # begin of the stereo exposure, of the PMD camera's in a frame of it alone; ns, same clock as
    # the header
    exposure_begin_ns: int = 0
    exposure_end_ns: int = 0  # end of it
    # age of the PMD data, ns: exposure middle of the stereo pair less that of the PMD data; 0
    # without either
    pmd_age_ns: int = 0
    compute_ns: int = 0  # what the frame took to compute, ns
    latency_ns: int = 0  # from the exposure middle to the sending of this packet, ns
    # pixels by source: none, stereo, PMD, both, resolved, conflict
    pixels_by_source: tuple = (0,) * 6
    counters: LoopCounters = dataclasses.field(default_factory=LoopCounters)
    pixels_by_cause: tuple = (0,) * 6  # pixels by cause, as in "Causes"
    drifts: tuple = (DriftReading(),) * 5  # drift of the rig from its calibration, see "Drift"
    drift_patches: int = 0  # patches of the picture that the drifts are known from
    drift_significant: int = 0  # bit k: drift k is significant; calibrate the rig anew
    tiles: tuple = (0,) * 8  # tiles of streams 1 to 8 in this frame; 0 = not sent
    pmd_present: int = 0  # 1: PMD data took part in this frame, 0: not
    # packets of parity that go with this frame, 255: so many or more; 0: none
    parity_groups: int = 0
    cloud_step: int = 0  # side of a cloud's block, px; 0: no cloud
    # that this frame stands on, the sum of: 1 the stereo pair, 2 the PMD camera; see "Sensors of a
    # frame"
    sensors: int = 0
    # of the settings this frame was made with: advances with every change
    settings_revision: int = 0
    # what each stage took, us: convert, match, fuse, watch; of the frame before: code, send
    # (without the waits of pacing)
    stage_us: tuple = (0,) * 6
    # frames in a row that this depth stands on, itself included: for how many the camera stood; 1:
    # it stands alone, as each of the PMD camera alone does
    steady_frames: int = 0
    # CRC-32C of the document of the settings this frame was made with, see "Settings"; 0: not told
    settings_fingerprint: int = 0
    # of the calibration this frame was made with, as in its message: the frame goes with no other
    # one; 0: not told
    calibration_fingerprint: int = 0
    max_range_um: int = 0  # maximal range that this frame was made with, um; 0: not told
    period_ns: int = 0  # of the trigger, that this frame was made with, ns; 0: not told

    LAYOUT: typing.ClassVar[tuple] = (
        ("exposure_begin_ns", "q", 1),
        ("exposure_end_ns", "q", 1),
        ("pmd_age_ns", "q", 1),
        ("compute_ns", "q", 1),
        ("latency_ns", "q", 1),
        ("pixels_by_source", "I", 6),
        ("counters", LoopCounters, 1),
        ("pixels_by_cause", "I", 6),
        ("drifts", DriftReading, 5),
        ("drift_patches", "I", 1),
        ("drift_significant", "I", 1),
        ("tiles", "H", 8),
        ("pmd_present", "B", 1),
        ("parity_groups", "B", 1),
        ("cloud_step", "B", 1),
        ("sensors", "B", 1),
        ("settings_revision", "I", 1),
        ("stage_us", "I", 6),
        ("steady_frames", "I", 1),
        ("settings_fingerprint", "I", 1),
        ("calibration_fingerprint", "I", 1),
        ("max_range_um", "I", 1),
        ("period_ns", "q", 1),
    )


@dataclasses.dataclass
class CalibrationPacket(Layout):
    """Type 64, with the first frame and then once a second."""

    image_width: int = 0  # pixels
    image_height: int = 0  # rows
    pmd_width: int = 0  # pixels; 0: no PMD camera
    pmd_height: int = 0  # rows
    fx: int = 0  # 1/65536 px, of the rectified left camera, in which depth is Z
    fy: int = 0  # 1/65536 px
    cx: int = 0  # 1/65536 px
    cy: int = 0  # 1/65536 px
    doff: int = 0  # 1/65536 px: cx of the right camera less that of the left
    depth_unit_um: int = 250  # of one step of depth and width, micrometres
    max_range: int = 0  # maximal range, depth units
    modulation_hz: int = 0  # PMD modulation frequency, Hz
    baseline_nm: int = 0  # nm
    period_ns: int = 0  # of the trigger, ns
    rotation: tuple = (0,) * 9  # R, row by row, 2^-30
    fingerprint: int = 0  # of the calibration: the CRC-32C at the end of its file; 0: not told
    translation_nm: tuple = (0,) * 3  # T, nm

    LAYOUT: typing.ClassVar[tuple] = (
        ("image_width", "H", 1),
        ("image_height", "H", 1),
        ("pmd_width", "H", 1),
        ("pmd_height", "H", 1),
        ("fx", "i", 1),
        ("fy", "i", 1),
        ("cx", "i", 1),
        ("cy", "i", 1),
        ("doff", "i", 1),
        ("depth_unit_um", "I", 1),
        ("max_range", "I", 1),
        ("modulation_hz", "I", 1),
        ("baseline_nm", "q", 1),
        ("period_ns", "q", 1),
        ("rotation", "i", 9),
        ("fingerprint", "I", 1),
        ("translation_nm", "q", 3),
    )


@dataclasses.dataclass
class HealthReport(Layout):
    """Type 65, once a second and on change, also while there are no frames."""

    uptime_ms: int = 0  # since the sender's start, ms
    active: int = 0  # bit k: condition k of "Events" is active
    severity: int = 0  # Severity: the highest of them
    reaction: int = 0  # Reaction: what the robot should do
    subscribers: int = 0  # that the streams go to now
    rate_millihertz: int = 0  # frames of the last second, 1/1000 Hz
    # mean of the last second: exposure middle to the sending of the last packet, us
    latency_us: int = 0
    longest_latency_us: int = 0  # longest of the last second, us
    settings_revision: int = 0  # as in the frame info
    counters: LoopCounters = dataclasses.field(default_factory=LoopCounters)
    packets_sent: int = 0  # datagrams to all subscribers
    control: ControlCounters = dataclasses.field(default_factory=ControlCounters)
    serial_sent: int = 0  # frames and messages on the serial line
    serial_dropped: int = 0  # of these, not sent: the line was busy
    serial_refused: int = 0  # frames and messages from the serial line that were damaged or unknown
    # sequence of the newest event, which made these conditions active; 1: there was none yet; 0:
    # not told
    events: int = 0

    LAYOUT: typing.ClassVar[tuple] = (
        ("uptime_ms", "Q", 1),
        ("active", "I", 1),
        ("severity", "B", 1),
        ("reaction", "B", 1),
        ("subscribers", "B", 1),
        ("", "x", 1),
        ("rate_millihertz", "I", 1),
        ("latency_us", "I", 1),
        ("longest_latency_us", "I", 1),
        ("settings_revision", "I", 1),
        ("counters", LoopCounters, 1),
        ("packets_sent", "Q", 1),
        ("control", ControlCounters, 1),
        ("serial_sent", "Q", 1),
        ("serial_dropped", "Q", 1),
        ("serial_refused", "Q", 1),
        ("events", "I", 1),
    )


@dataclasses.dataclass
class EventReport(Layout):
    """Type 67."""

    sequence: int = 0  # advances with each change, the first is 2; the repetition has the same
    condition: int = 0  # Condition: see "Events"
    severity: int = 0  # Severity: of it
    reaction: int = 0  # Reaction: what the robot should do while it is active
    active: int = 0  # 1: it began, 0: it ended
    count: int = 0  # how often it has begun since the sender's start
    value: int = 0  # depends on the condition
    at_ns: int = 0  # when, ns, clock of the header
    # of calibration changed: the fingerprint of the one before; of release on trial: the
    # fingerprint of the release; of settings changed: 1 the network is on trial until an admin
    # saves it, 2 it is as before, since nobody did, else 0; else 0
    former: int = 0

    LAYOUT: typing.ClassVar[tuple] = (
        ("sequence", "I", 1),
        ("condition", "B", 1),
        ("severity", "B", 1),
        ("reaction", "B", 1),
        ("active", "B", 1),
        ("count", "I", 1),
        ("value", "I", 1),
        ("at_ns", "q", 1),
        ("former", "I", 1),
    )


@dataclasses.dataclass
class ParityFields(Layout):
    """Type 66. After these fields the exclusive or of the payloads of the group, each filled up with
    0 to the longest."""

    count: int = 0  # packets of the frame, as in the headers of its parts
    type: int = 0  # exclusive or over the group's packets, as all that follow: type
    flags: int = 0  # flags
    stream: int = 0  # stream
    codec: int = 0  # codec
    image_width: int = 0  # image width
    image_height: int = 0  # image height
    first_row: int = 0  # first row
    first_column: int = 0  # first column
    pixel_count: int = 0  # pixel count
    payload_length: int = 0  # payload length

    LAYOUT: typing.ClassVar[tuple] = (
        ("count", "H", 1),
        ("type", "B", 1),
        ("flags", "B", 1),
        ("stream", "B", 1),
        ("codec", "B", 1),
        ("image_width", "H", 1),
        ("image_height", "H", 1),
        ("first_row", "H", 1),
        ("first_column", "H", 1),
        ("pixel_count", "H", 1),
        ("payload_length", "H", 1),
    )


@dataclasses.dataclass
class Announce(Layout):
    """Type 68."""

    request_id: int = 0  # of the discover that it answers; 0 in the beacon
    port: int = 0  # UDP port of the sensor for requests
    subscribers: int = 0  # now
    most_subscribers: int = 0  # that it takes
    serial: str = ""  # serial number, UTF-8, filled up with 0, as all texts
    name: str = ""  # given by whoever owns it
    version: str = ""  # of its software
    board: str = ""  # what it is
    uptime_ms: int = 0  # since its start, ms
    image_width: int = 0  # of its depth, pixels
    image_height: int = 0  # rows
    rate_millihertz: int = 0  # frames of the last second, 1/1000 Hz
    state: int = 0  # SensorState: whether there are frames

    LAYOUT: typing.ClassVar[tuple] = (
        ("request_id", "I", 1),
        ("port", "H", 1),
        ("subscribers", "B", 1),
        ("most_subscribers", "B", 1),
        ("serial", "B", 16),
        ("name", "B", 32),
        ("version", "B", 16),
        ("board", "B", 16),
        ("uptime_ms", "Q", 1),
        ("image_width", "H", 1),
        ("image_height", "H", 1),
        ("rate_millihertz", "I", 1),
        ("state", "B", 1),
        ("", "x", 23),
    )


@dataclasses.dataclass
class SectorReport(Layout):
    """Type 69: the nearest obstacle in each of 72 directions, by its near bound."""

    # direction of the middle of the first sector, millionths of a degree, clockwise from straight
    # ahead
    first_udeg: int = 0
    step_udeg: int = 0  # from one sector to the next
    least_cm: int = 0  # nearest distance that can be told
    most_cm: int = 0  # furthest
    # horizontal distance from the camera, rounded towards it; 65535: unknown
    distances_cm: tuple = (0,) * 72

    LAYOUT: typing.ClassVar[tuple] = (
        ("first_udeg", "i", 1),
        ("step_udeg", "I", 1),
        ("least_cm", "H", 1),
        ("most_cm", "H", 1),
        ("distances_cm", "H", 72),
    )


@dataclasses.dataclass
class RawInfo(Layout):
    """Type 70: the exposure that raw pictures are of."""

    edge_ns: int = 0  # trigger edge that it was collected at, ns, same clock as the header
    # exposure of the left and of the right camera; 0 without a pair
    pair_exposures: tuple = (Window(),) * 2
    pmd_exposures: tuple = (Window(),) * 4  # exposure of A0 to A3; 0 without samples
    # of the left, the right and the PMD camera, as each counts its exposures
    sequences: tuple = (0,) * 3
    # of these pictures, from 1: advances with each exposure whose pictures were begun for this
    # request
    number: int = 0
    # exposures that were due and not sent, or not to their end, for this request: the link or the
    # sensor had no time for them
    dropped: int = 0
    # of each picture of the pair as it is sent, pixels; 0: the part that was asked for lies outside
    width: int = 0
    height: int = 0  # rows
    column: int = 0  # first column of it, pixels of the camera
    row: int = 0  # first row
    # of the whole picture of each camera of the pair, pixels; 0 without a pair
    camera_width: int = 0
    camera_height: int = 0  # rows
    pmd_width: int = 0  # of each sample, pixels; 0 without samples
    pmd_height: int = 0  # rows
    pictures: int = 0  # that follow, the sum as in the request
    step: int = 0  # from one column or row of the pair to the next, pixels of the camera
    # of what the frame was computed with, since the exposure sent before, the sum of: 1 all that
    # counts from frame to frame was begun anew; 2 depth was averaged with no frame before
    state: int = 0
    pmd_every: int = 0  # the PMD camera exposes at every so many-th edge
    disparities: int = 0  # candidates of the search, which settings may leave to the rig

    LAYOUT: typing.ClassVar[tuple] = (
        ("edge_ns", "q", 1),
        ("pair_exposures", Window, 2),
        ("pmd_exposures", Window, 4),
        ("sequences", "I", 3),
        ("number", "I", 1),
        ("dropped", "I", 1),
        ("width", "H", 1),
        ("height", "H", 1),
        ("column", "H", 1),
        ("row", "H", 1),
        ("camera_width", "H", 1),
        ("camera_height", "H", 1),
        ("pmd_width", "H", 1),
        ("pmd_height", "H", 1),
        ("pictures", "B", 1),
        ("step", "B", 1),
        ("state", "B", 1),
        ("pmd_every", "B", 1),
        ("disparities", "H", 1),
        ("", "x", 2),
    )


@dataclasses.dataclass
class Subscribe(Layout):
    """Types 128 and 130, to the sensor."""

    request_id: int = 0  # any number, comes back in the answer
    # how long to send without hearing from us; the sensor takes 500 to 10,000, 0: 3,000
    lease_ms: int = 0
    cookie: int = 0  # of an answer; 0: none yet
    # of a signed subscribe: number of the stream key that we have, 0: none; see "Signed streams"
    stream_key: int = 0
    raw: RawRequest = dataclasses.field(default_factory=RawRequest)

    LAYOUT: typing.ClassVar[tuple] = (
        ("request_id", "I", 1),
        ("lease_ms", "H", 1),
        ("", "x", 2),
        ("cookie", "Q", 1),
        ("stream_key", "I", 1),
        ("raw", RawRequest, 1),
    )


@dataclasses.dataclass
class Subscribed(Layout):
    """Type 129."""

    request_id: int = 0  # of the request
    result: int = 0  # SubscribeResult: see below
    subscribers: int = 0  # now
    lease_ms: int = 0  # granted; ask again before it is over, best after a third of it
    cookie: int = 0  # for the next request

    LAYOUT: typing.ClassVar[tuple] = (
        ("request_id", "I", 1),
        ("result", "B", 1),
        ("subscribers", "B", 1),
        ("lease_ms", "H", 1),
        ("cookie", "Q", 1),
    )


@dataclasses.dataclass
class SettingsRequest(Layout):
    """Type 132. The text follows, up to the end of the payload, at most 1,024 bytes."""

    request_id: int = 0  # any number, comes back in the answer
    operation: int = 0  # SettingsOperation: see "Settings"
    document: int = 0  # SettingsDocument: of get
    offset: int = 0  # of get and keys: where the answer's text begins in the document, bytes
    cookie: int = 0  # of an answer; 0: none yet. Not looked at on serial lines

    LAYOUT: typing.ClassVar[tuple] = (
        ("request_id", "I", 1),
        ("operation", "B", 1),
        ("document", "B", 1),
        ("offset", "H", 1),
        ("cookie", "Q", 1),
        ("", "x", 8),
    )


@dataclasses.dataclass
class SettingsAnswer(Layout):
    """Type 133. The text follows, up to the end of the payload."""

    request_id: int = 0  # of the request
    result: int = 0  # SettingsResult: see "Settings"
    restart: int = 0  # 1: some of the active settings wait for the next start
    total: int = 0  # of get and keys: length of the document, bytes
    revision: int = 0  # of the active settings: advances with every change
    cookie: int = 0  # for the next request

    LAYOUT: typing.ClassVar[tuple] = (
        ("request_id", "I", 1),
        ("result", "B", 1),
        ("restart", "B", 1),
        ("total", "H", 1),
        ("revision", "I", 1),
        ("", "x", 4),
        ("cookie", "Q", 1),
    )


@dataclasses.dataclass
class SignedFields(Layout):
    """Types 136 and 137. After these fields the payload of the message that is signed, then the tag,
    the last 16 bytes of the payload."""

    key_id: int = 0  # of the key; in the answer the same
    type: int = 0  # type of the message that is signed: 128, 130 or 132, in the answer 129 or 133
    counter: int = 0  # above all that this key has signed in this session; in the answer the same
    highest: int = 0  # of the answer: the highest counter of this key so far; in requests 0

    LAYOUT: typing.ClassVar[tuple] = (
        ("key_id", "I", 1),
        ("type", "B", 1),
        ("", "x", 3),
        ("counter", "Q", 1),
        ("highest", "Q", 1),
    )


@dataclasses.dataclass
class UploadRequest(Layout):
    """Behind a `settings_request` of operation upload, in place of its text. The bytes of the chunk
    follow, up to the end of the payload."""

    step: int = 0  # UploadStep: see "Uploads"
    kind: int = 0  # UploadKind: of what is uploaded
    total: int = 0  # bytes of it all
    offset: int = 0  # of chunk: where its bytes begin
    hash: tuple = (0,) * 32  # of it all: BLAKE2b of 32 bytes

    LAYOUT: typing.ClassVar[tuple] = (
        ("step", "B", 1),
        ("kind", "B", 1),
        ("", "x", 2),
        ("total", "I", 1),
        ("offset", "I", 1),
        ("", "x", 4),
        ("hash", "B", 32),
    )


@dataclasses.dataclass
class UploadAnswer(Layout):
    """Behind the `settings_answer` with result ok to it, in place of its text."""

    wanted: int = 0  # offset of the next chunk: all before it is there; the total: commit
    chunk: int = 0  # bytes of a chunk, at most
    state: int = 0  # UploadState: of what is in force
    # of the calibration that is in force; of updates the CRC-32C of the release's head that runs,
    # 0: none
    fingerprint: int = 0
    # of commit and revert: of the calibration that was in force before; of updates of the whole
    # release in the other slot, 0: none
    former: int = 0

    LAYOUT: typing.ClassVar[tuple] = (
        ("wanted", "I", 1),
        ("chunk", "H", 1),
        ("state", "H", 1),
        ("fingerprint", "I", 1),
        ("former", "I", 1),
    )


@dataclasses.dataclass
class DownloadRequest(Layout):
    """Behind a `settings_request` of operation download, in place of its text."""

    kind: int = 0  # UploadKind: of what is read: those of uploads
    offset: int = 0  # where the bytes of the answer begin

    LAYOUT: typing.ClassVar[tuple] = (
        ("kind", "B", 1),
        ("", "x", 3),
        ("offset", "I", 1),
    )


@dataclasses.dataclass
class DownloadAnswer(Layout):
    """Behind the `settings_answer` with result ok to it, in place of its text. Bytes of what is in
    force follow, up to the end of the payload."""

    total: int = 0  # bytes of it all
    offset: int = 0  # as it was asked for
    fingerprint: int = 0  # of the calibration that is in force; of other kinds 0

    LAYOUT: typing.ClassVar[tuple] = (
        ("total", "I", 1),
        ("offset", "I", 1),
        ("fingerprint", "I", 1),
        ("", "x", 4),
    )


@dataclasses.dataclass
class StreamKeyFields(Layout):
    """Behind the `subscribed` of a signed answer."""

    number: int = 0  # of the stream key, as in the datagrams that it signs; 0: none is handed over
    # how tags are made: 1, with keys of blocks of 16, as below; a receiver takes no stream key with
    # another value
    tags: int = 1
    sealed: tuple = (0,) * 32  # the stream key, exclusive or the pad of this answer

    LAYOUT: typing.ClassVar[tuple] = (
        ("number", "I", 1),
        ("tags", "B", 1),
        ("", "x", 3),
        ("sealed", "B", 32),
    )


@dataclasses.dataclass
class StreamSignature(Layout):
    """Bytes 52 to 79 of a datagram that a stream key signs."""

    number: int = 0  # of the stream key; 0: not signed
    counter: int = 0  # of the datagrams that this key signs: rises by one with each, from 1
    tag: tuple = (0,) * 16  # of all else in the datagram but the CRC

    LAYOUT: typing.ClassVar[tuple] = (
        ("number", "I", 1),
        ("counter", "Q", 1),
        ("tag", "B", 16),
    )


@dataclasses.dataclass
class PairRequest(Layout):
    """Type 138, to the sensor."""

    request_id: int = 0  # any number, comes back in the answer
    step: int = 0  # PairStep: see below
    # PairMethod: see below; the same in all steps. Role, key id and name count at begin
    method: int = 0
    # Role: that the key shall have; a key that is renewed keeps its own, and its name, whatever is
    # named
    role: int = 0
    cookie: int = 0  # of an answer; 0: none yet. Not looked at on serial lines
    attempt: int = 0  # of the answer to begin; there 0
    key_id: int = 0  # of method key; else 0
    name: str = ""  # whose key it is
    value: tuple = (0,) * 32  # depends on the step
    # of reveal: the client's; of open: of this opening; of begin with method code or key: the proof
    # that the client knows it, see below, or 0
    nonce: tuple = (0,) * 16

    LAYOUT: typing.ClassVar[tuple] = (
        ("request_id", "I", 1),
        ("step", "B", 1),
        ("method", "B", 1),
        ("role", "B", 1),
        ("", "x", 1),
        ("cookie", "Q", 1),
        ("attempt", "Q", 1),
        ("key_id", "I", 1),
        ("", "x", 4),
        ("name", "B", 32),
        ("value", "B", 32),
        ("nonce", "B", 16),
    )


@dataclasses.dataclass
class PairAnswer(Layout):
    """Type 139."""

    request_id: int = 0  # of the request
    result: int = 0  # PairResult: see below
    cookie: int = 0  # for the next request
    attempt: int = 0  # random, for the steps that follow
    key_id: int = 0  # of the key that comes of it
    # of begin: the sensor's public key; of reveal and confirm: begins with a tag of the sensor; of
    # open and accept with `waiting`: what is asked for, see below
    value: tuple = (0,) * 32
    nonce: tuple = (0,) * 16  # of begin: the sensor's

    LAYOUT: typing.ClassVar[tuple] = (
        ("request_id", "I", 1),
        ("result", "B", 1),
        ("", "x", 3),
        ("cookie", "Q", 1),
        ("attempt", "Q", 1),
        ("key_id", "I", 1),
        ("", "x", 4),
        ("value", "B", 32),
        ("nonce", "B", 16),
    )


@dataclasses.dataclass
class Discover(Layout):
    """Type 134, to the sensor, also by broadcast."""

    request_id: int = 0  # any number but 0, comes back in the answer

    LAYOUT: typing.ClassVar[tuple] = (
        ("request_id", "I", 1),
        ("", "x", 124),
    )


# The payload of each type that is one message; what follows it is text or data.
MESSAGES = {
    PacketType.FRAME_INFO: FrameInfo,
    PacketType.CALIBRATION: CalibrationPacket,
    PacketType.HEALTH: HealthReport,
    PacketType.EVENT: EventReport,
    PacketType.PARITY: ParityFields,
    PacketType.ANNOUNCE: Announce,
    PacketType.SECTORS: SectorReport,
    PacketType.RAW_INFO: RawInfo,
    PacketType.SUBSCRIBE: Subscribe,
    PacketType.UNSUBSCRIBE: Subscribe,
    PacketType.SUBSCRIBED: Subscribed,
    PacketType.SETTINGS_REQUEST: SettingsRequest,
    PacketType.SETTINGS_ANSWER: SettingsAnswer,
    PacketType.SIGNED_REQUEST: SignedFields,
    PacketType.SIGNED_ANSWER: SignedFields,
    PacketType.PAIR_REQUEST: PairRequest,
    PacketType.PAIR_ANSWER: PairAnswer,
    PacketType.DISCOVER: Discover,
}
# made: end


def _crc_table():
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = byte >> 1 ^ (0x82F63B78 if byte & 1 else 0)
        table.append(byte)
    return tuple(table)


_CRC_TABLE = _crc_table()


def crc32c(data, before=0):
    """CRC-32C (Castagnoli); of b"123456789" it is 0xE3069283. `before`: of what precedes."""
    crc = before ^ 0xFFFFFFFF
    for byte in data:
        crc = crc >> 8 ^ _CRC_TABLE[(crc ^ byte) & 0xFF]
    return crc ^ 0xFFFFFFFF


def parse(datagram):
    """(Header, payload) of a verified packet. Raises Refused: truncated, magic, version, length,
    crc or field."""
    if len(datagram) < Header.size() + CRC_BYTES:
        raise Refused("truncated")
    header = Header.unpack(datagram)
    if header.magic != Header.magic:
        raise Refused("magic")
    if header.version != Header.version:
        raise Refused("version")
    if header.header_length < Header.size():
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
    return header, bytes(datagram[header.header_length:end])


def signature(datagram):
    """The StreamSignature of a datagram that parse() took; None: it is not signed. What it is worth takes the stream
    key: see "Signed streams" of docs/WIRE.md."""
    header = Header.unpack(datagram)
    if header.header_length < Header.size() + StreamSignature.size():
        return None
    found = StreamSignature.unpack(datagram[Header.size():])
    return found if found.number else None


def seal(header, payload=b""):
    """The datagram of a header and a payload; lengths and CRC are filled in. Raises ValueError."""
    header = dataclasses.replace(header, header_length=Header.size(), payload_length=len(payload))
    packet = header.pack() + payload
    if len(packet) + CRC_BYTES > MAX_DATAGRAM:
        raise ValueError(f"a payload of {len(payload)} bytes does not fit a datagram")
    return packet + crc32c(packet).to_bytes(CRC_BYTES, "little")
