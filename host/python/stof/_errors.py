"""What goes wrong, as exceptions: the text is one line for a person, `status` the number of stof.h."""

from __future__ import annotations


class Error(Exception):
    """Any of the errors below."""

    status: int = 11

    def __init__(self, text: str, status: int | None = None) -> None:
        super().__init__(text)
        if status is not None:
            self.status = status


class Timeout(Error, TimeoutError):
    """Nothing came in time: call again."""

    status = 1


class BadArgument(Error, ValueError):
    """A text that is no address, a file of keys that cannot be used, a number out of its range."""

    status = 2


class Unreachable(Error, ConnectionError):
    """No such host, no such port to be had, no answer."""

    status = 3


class Lost(Error, ConnectionError):
    """The socket failed: close the sensor, then open it again."""

    status = 4


class NotYet(Error):
    """The sensor has not sent that so far."""

    status = 5


class Busy(Error):
    """Another thread waits for a frame of this sensor."""

    status = 6


class Refused(Error):
    """The sensor refused the settings; the text says which field and what it takes, or that it takes a key."""

    status = 8


class NoMemory(Error, MemoryError):
    """The library got no memory."""

    status = 9


class Unsupported(Error):
    """The sensor or the library cannot do that."""

    status = 10


class NotFound(Error, LookupError):
    """No sensor, or more than one, has that serial number or name."""

    status = 3


class End(Error):
    """The recording is over: open it again to begin anew."""

    status = 12


class FileFailed(Error, OSError):
    """A file cannot be read or written; the text says which, and why."""

    status = 13


class Closed(Error, ValueError):
    """The sensor was closed."""

    status = 2


class LibraryError(ImportError):
    """There is no libstof, or one that this package was not written for."""


_BY_STATUS: dict[int, type[Error]] = {
    kind.status: kind for kind in (Timeout, BadArgument, Unreachable, Lost, NotYet, Busy, Refused, NoMemory, Unsupported, End, FileFailed)
}


def error_of(status: int, text: str) -> Error:
    return _BY_STATUS.get(status, Error)(text, status)
