"""A stof depth sensor in Python: libstof by ctypes, images as numpy arrays without a copy.

import stof

with stof.open("192.168.1.20") as sensor:
    for frame in sensor:
        print(frame.number, frame.depth.shape, frame.depth.max())  # steps of 0.25 mm, 0: none

docs/PYTHON.md has more. Images take numpy, all else the standard library alone. Times are nanoseconds or seconds by the
sensor's clock, where they do not say otherwise.
"""

from ._errors import (BadArgument, Busy, Closed, End, Error, FileFailed, LibraryError, Lost, NoMemory, NotFound, NotYet, Refused, Timeout, Unreachable,
                      Unsupported)
from ._frame import Frame, Raw
from ._library import version as _version
from ._sensor import Sensor, discover, open  # noqa: A004
from ._values import (Answer, Calibration, Cause, Clock, Condition, Document, Event, Found, FoundBy, Health, HealthState, Info, Link,
                      LinkCondition, LinkEvent, Reaction, Recorded, SensorSet, Setting, Severity, Source)

__version__: str = _version()  # of the library in use

__all__ = ["Answer", "BadArgument", "Busy", "Calibration", "Cause", "Clock", "Closed", "Condition", "Document", "End", "Error", "Event", "FileFailed", "Found", "FoundBy",
           "Frame", "Health", "HealthState", "Info", "LibraryError", "Link", "LinkCondition", "LinkEvent", "Lost", "NoMemory", "NotFound", "NotYet",
           "Raw", "Reaction", "Recorded", "Refused", "Sensor", "SensorSet", "Setting", "Severity", "Source", "Timeout", "Unreachable", "Unsupported", "discover", "open"]

for _public in __all__:  # as users know them, also in tracebacks
    if isinstance(globals()[_public], type):
        globals()[_public].__module__ = __name__
del _public
