"""libstof's C interface by ctypes: the structures of stof.h, and the library, found and checked.

The library is that of $STOF_LIBRARY, else the one that a wheel brings beside this file, else the system's libstof.so.0.
"""

from __future__ import annotations

import ctypes
import os
import pathlib
from ctypes import POINTER, c_char, c_char_p, c_double, c_float, c_int, c_int16, c_int32, c_int64, c_size_t, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p

from ._errors import LibraryError

SONAME = "libstof.so.0"
MAJOR = "0"


class Options(ctypes.Structure):
    _name_ = "stof_options"
    _fields_ = [("struct_size", c_uint32), ("device_id", c_uint32), ("sensor", c_char_p), ("bind", c_char_p), ("port", c_uint16),
                ("reserved", c_uint16), ("socket_buffer", c_uint32), ("max_pixels", c_uint32), ("max_age_ms", c_uint32),
                ("signed_streams", c_uint32), ("keys", c_char_p), ("key_id", c_uint32), ("reserved_2", c_uint32), ("raw_pictures", c_uint32),
                ("raw_every", c_uint16), ("raw_step", c_uint16), ("raw_part", c_uint16 * 4), ("recording", c_char_p), ("line", c_char_p),
                ("baud", c_uint32), ("pace_percent", c_uint32)]


class Plane(ctypes.Structure):
    _name_ = "stof_plane"
    _fields_ = [("data", c_void_p), ("width", c_uint32), ("height", c_uint32), ("stride", c_size_t), ("bytes", c_size_t),
                ("pixel_bytes", c_uint32), ("missing", c_uint32), ("marks", c_void_p), ("marks_stride", c_size_t), ("mark", c_uint8),
                ("reserved", c_uint8 * 7)]


class Calibration(ctypes.Structure):
    _name_ = "stof_calibration"
    _fields_ = [("width", c_uint32), ("height", c_uint32), ("fx", c_double), ("fy", c_double), ("cx", c_double), ("cy", c_double),
                ("doff", c_double), ("k", c_double * 9), ("baseline_m", c_double), ("depth_unit_m", c_double), ("max_range_m", c_double),
                ("period_s", c_double), ("pmd_width", c_uint32), ("pmd_height", c_uint32), ("modulation_hz", c_double),
                ("r", c_double * 9), ("t", c_double * 3)]


class Info(ctypes.Structure):
    _name_ = "stof_info"
    _fields_ = [("exposure_begin_ns", c_int64), ("exposure_end_ns", c_int64), ("pmd_age_ns", c_int64), ("compute_ns", c_int64),
                ("latency_ns", c_int64), ("pixels_by_source", c_uint32 * 6), ("pixels_by_cause", c_uint32 * 6),
                ("settings_revision", c_uint32), ("pmd_present", c_uint8), ("cloud_step", c_uint8), ("sensors", c_uint8),
                ("reserved", c_uint8)]


class CloudPoint(ctypes.Structure):
    _name_ = "stof_cloud_point"
    _fields_ = [("x_mm", c_int16), ("y_mm", c_int16), ("depth", c_uint16), ("interval_width", c_uint16)]


class Frame(ctypes.Structure):
    _name_ = "stof_frame"
    _fields_ = [("struct_size", c_uint32), ("device_id", c_uint32), ("session_id", c_uint32), ("number", c_uint32),
                ("freshness", c_uint32), ("health", c_uint32), ("exposure_middle_ns", c_int64), ("first_packet_ns", c_int64),
                ("last_packet_ns", c_int64), ("packets", c_uint32), ("missing_packets", c_uint32), ("recovered_packets", c_uint32),
                ("emulated", c_uint8), ("has_info", c_uint8), ("has_calibration", c_uint8), ("reserved", c_uint8), ("depth", Plane),
                ("interval_width", Plane), ("source", Plane), ("cause", Plane), ("disparity", Plane), ("pmd", Plane * 4), ("left", Plane),
                ("right", Plane), ("cloud", Plane), ("info", Info), ("calibration", Calibration), ("self", c_void_p),
                ("settings_fingerprint", c_uint32), ("steady_frames", c_uint32), ("calibration_fingerprint", c_uint32),
                ("reserved2", c_uint32), ("exposure_here_ns", c_int64), ("recorded_ns", c_int64)]


class PixelPoint(ctypes.Structure):
    _name_ = "stof_pixel_point"
    _fields_ = [("x", c_float), ("y", c_float), ("z", c_float), ("z_width", c_float), ("u", c_uint16), ("v", c_uint16), ("source", c_uint8),
                ("cause", c_uint8), ("grey", c_uint8), ("has_grey", c_uint8)]


class Raw(ctypes.Structure):
    _name_ = "stof_raw"
    _fields_ = [("struct_size", c_uint32), ("device_id", c_uint32), ("session_id", c_uint32), ("frame_number", c_uint32), ("freshness", c_uint32),
                ("number", c_uint32), ("dropped", c_uint32), ("pictures", c_uint32), ("missing", c_uint32), ("reserved", c_uint32),
                ("edge_ns", c_int64), ("exposure_middle_ns", c_int64), ("column", c_uint16), ("row", c_uint16), ("step", c_uint16),
                ("reserved2", c_uint16), ("camera_width", c_uint16), ("camera_height", c_uint16), ("state", c_uint16), ("pmd_every", c_uint16),
                ("left", Plane), ("right", Plane), ("pmd", Plane * 4)]


class Point(ctypes.Structure):
    _name_ = "stof_point"
    _fields_ = [("x", c_float), ("y", c_float), ("z", c_float), ("z_width", c_float), ("source", c_uint32)]


HEALTH_COUNTERS = ("edges", "mispaired", "timeouts", "deadline_misses", "link_drops", "accepted", "truncated", "bad_magic", "bad_version",
                   "bad_length", "bad_crc", "bad_field", "not_control", "foreign", "too_short", "cookies", "busy", "overrun", "forged", "replayed",
                   "serial_sent", "serial_dropped", "serial_refused")


class Health(ctypes.Structure):
    _name_ = "stof_health"
    _fields_ = [("struct_size", c_uint32), ("active", c_uint32), ("severity", c_uint32), ("reaction", c_uint32), ("uptime_ms", c_uint64),
                ("rate_hz", c_double), ("latency_s", c_double), ("longest_latency_s", c_double), ("frames_published", c_uint64),
                ("packets_sent", c_uint64), ("subscribers", c_uint32), ("settings_revision", c_uint32),
                *((name, c_uint64) for name in HEALTH_COUNTERS), ("age_ns", c_int64), ("silent", c_uint32), ("reserved", c_uint32)]


class RecordOptions(ctypes.Structure):
    _name_ = "stof_record_options"
    _fields_ = [("struct_size", c_uint32), ("replace", c_uint32)]


class Recorded(ctypes.Structure):
    _name_ = "stof_recorded"
    _fields_ = [("struct_size", c_uint32), ("recording", c_uint32), ("frames", c_uint64), ("frames_dropped", c_uint64), ("bytes", c_uint64),
                ("failed", c_uint32), ("indexed", c_uint32)]


class Event(ctypes.Structure):
    _name_ = "stof_event"
    _fields_ = [("struct_size", c_uint32), ("sequence", c_uint32), ("condition", c_uint32), ("severity", c_uint32),
                ("reaction", c_uint32), ("active", c_uint32), ("count", c_uint32), ("value", c_uint32), ("at_ns", c_int64)]


class Link(ctypes.Structure):
    _name_ = "stof_link"
    _fields_ = [("struct_size", c_uint32), ("conditions", c_uint32), ("frame_age_ns", c_int64), ("health_age_ns", c_int64),
                ("calibration_age_ns", c_int64), ("restarts", c_uint32), ("reserved", c_uint32)]


class LinkEvent(ctypes.Structure):
    _name_ = "stof_link_event"
    _fields_ = [("struct_size", c_uint32), ("condition", c_uint32), ("active", c_uint32), ("count", c_uint32), ("at_ns", c_int64)]


class Clock(ctypes.Structure):
    _name_ = "stof_clock"
    _fields_ = [("struct_size", c_uint32), ("reserved", c_uint32), ("offset_ns", c_int64), ("spread_ns", c_int64), ("age_ns", c_int64)]


class Setting(ctypes.Structure):
    _name_ = "stof_setting"
    _fields_ = [("struct_size", c_uint32), ("kind", c_uint32), ("value", c_int64), ("minimum", c_int64), ("maximum", c_int64),
                ("default_value", c_int64), ("at_restart", c_uint32), ("reserved", c_uint32), ("text", c_char * 64), ("unit", c_char * 16),
                ("choices", c_char * 160)]


COUNTERS = ("packets", "packets_ok", "packets_refused", "packets_unknown", "packets_foreign", "packets_duplicate", "packets_late",
            "packets_missing", "packets_recovered", "frames_complete", "frames_incomplete", "frames_stale", "frames_lost",
            "frames_dropped", "sessions", "socket_drops", "packets_old", "packets_implausible", "frames_old", "resynchronised",
            "packets_not_signed", "packets_forged")


class Statistics(ctypes.Structure):
    _name_ = "stof_statistics"
    _fields_ = [("struct_size", c_uint32), ("socket_buffer", c_uint32), *((name, c_uint64) for name in COUNTERS)]


class Answer(ctypes.Structure):
    _name_ = "stof_answer"
    _fields_ = [("struct_size", c_uint32), ("revision", c_uint32), ("restart", c_uint32), ("reserved", c_uint32), ("text_length", c_size_t)]


class Found(ctypes.Structure):
    _name_ = "stof_found"
    _fields_ = [("serial", c_char * 17), ("name", c_char * 33), ("version", c_char * 17), ("board", c_char * 17), ("endpoint", c_char * 84),
                ("device_id", c_uint32), ("found_by", c_uint32), ("health", c_int32), ("rate_hz", c_float), ("subscribers", c_uint32),
                ("most_subscribers", c_uint32)]


# The first ones never change: they lie in others and in arrays. The others begin with their size, or their
# size is an argument, and may grow.
FIXED = (Plane, Calibration, Info, CloudPoint, Point, PixelPoint)
GROWING = (Options, Frame, Health, Event, Link, LinkEvent, Clock, Setting, Raw, Statistics, Answer, Found, RecordOptions, Recorded)

_SENSOR = c_void_p
_FUNCTIONS = {
    "stof_version": (c_char_p, []),
    "stof_struct_size": (c_size_t, [c_char_p]),
    "stof_status_text": (c_char_p, [c_int]),
    "stof_open": (c_int, [POINTER(Options), POINTER(_SENSOR), c_char_p, c_size_t]),
    "stof_close": (None, [_SENSOR]),
    "stof_next": (c_int, [_SENSOR, c_int, POINTER(Frame)]),
    "stof_keep": (c_int, [POINTER(Frame), POINTER(c_void_p)]),
    "stof_release": (None, [c_void_p]),
    "stof_fd": (c_int, [_SENSOR]),
    "stof_due_ms": (c_int, [_SENSOR]),
    "stof_points": (c_int, [POINTER(Frame), c_void_p, c_size_t, POINTER(c_size_t)]),
    "stof_pixel_points": (c_int, [POINTER(Frame), c_void_p, c_size_t, POINTER(c_size_t)]),
    "stof_hold": (c_void_p, [c_void_p]),
    "stof_next_raw": (c_int, [_SENSOR, POINTER(Raw)]),
    "stof_next_link_event": (c_int, [_SENSOR, POINTER(LinkEvent)]),
    "stof_link_condition_name": (c_char_p, [c_uint32]),
    "stof_record": (c_int, [_SENSOR, c_char_p, POINTER(RecordOptions), c_char_p, c_size_t]),
    "stof_record_end": (c_int, [_SENSOR, POINTER(Recorded), c_char_p, c_size_t]),
    "stof_get_recorded": (c_int, [_SENSOR, POINTER(Recorded)]),
    "stof_get_clock": (c_int, [_SENSOR, POINTER(Clock)]),
    "stof_get_setting": (c_int, [_SENSOR, c_char_p, POINTER(Setting), c_char_p, c_size_t]),
    "stof_set_integer": (c_int, [_SENSOR, c_char_p, c_int64, c_char_p, c_size_t]),
    "stof_set_boolean": (c_int, [_SENSOR, c_char_p, c_int, c_char_p, c_size_t]),
    "stof_set_text": (c_int, [_SENSOR, c_char_p, c_char_p, c_char_p, c_size_t]),
    "stof_get_health": (c_int, [_SENSOR, POINTER(Health)]),
    "stof_next_event": (c_int, [_SENSOR, POINTER(Event)]),
    "stof_condition_name": (c_char_p, [c_uint32]),
    "stof_condition_text": (c_char_p, [c_uint32]),
    "stof_get_link": (c_int, [_SENSOR, POINTER(Link)]),
    "stof_get_statistics": (c_int, [_SENSOR, POINTER(Statistics)]),
    "stof_advice": (c_size_t, [_SENSOR, c_char_p, c_size_t]),
    "stof_settings": (c_int, [_SENSOR, c_int, c_int, c_char_p, c_char_p, c_size_t, POINTER(Answer)]),
    "stof_discover": (c_int, [c_int, POINTER(c_char_p), c_size_t, POINTER(Found), c_size_t, c_size_t, POINTER(c_size_t), c_char_p,
                              c_size_t]),
}


def file_of_library() -> str:
    named = os.environ.get("STOF_LIBRARY")
    if named:
        return named
    beside = pathlib.Path(__file__).with_name(SONAME)
    return str(beside) if beside.exists() else SONAME


def load(file: str) -> ctypes.CDLL:
    """Raises LibraryError: there is none, it lacks a function, is of another major version, or has other structures."""
    try:
        library = ctypes.CDLL(file)
    except OSError as error:
        raise LibraryError(f"stof: libstof cannot be loaded: {error}; install libstof0, or name one by STOF_LIBRARY") from None
    for name, (result, arguments) in _FUNCTIONS.items():
        try:
            function = getattr(library, name)
        except AttributeError:
            raise LibraryError(f"stof: {file} has no {name}: it is not libstof, or older than this package; install one that fits") from None
        function.restype = result
        function.argtypes = arguments
    version = library.stof_version().decode(errors="replace")
    if version.split(".")[0] != MAJOR:
        raise LibraryError(f"stof: {file} is libstof {version}, this package is for {MAJOR}.x: install both of one version")
    for structure in (*FIXED, *GROWING):
        there = library.stof_struct_size(structure._name_.encode())
        here = ctypes.sizeof(structure)
        if there < here or (there > here and structure in FIXED):
            raise LibraryError(f"stof: {structure._name_} has {there} bytes in {file} (libstof {version}) and {here} in this package: "
                               "install both of one version")
    return library


library = load(file_of_library())


def text(value: bytes | None) -> str:
    return (value or b"").decode(errors="replace")


def version() -> str:
    return text(library.stof_version())
