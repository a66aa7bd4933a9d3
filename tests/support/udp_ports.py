"""Ports of UDP for programs that end and start again."""

import pathlib
import random
import socket

FIRST = 10_000
RANGE = pathlib.Path("/proc/sys/net/ipv4/ip_local_port_range")


def lasting_port():
    """One that is free and that no system gives away by itself: while its program starts again, no other test's program gets it.
    0, which is any, where there is none."""
    try:
        end = int(RANGE.read_text(encoding="ascii").split()[0])
    except (OSError, ValueError, IndexError):
        end = 32_768
    for _ in range(100 if end > FIRST else 0):
        port = random.randrange(FIRST, end)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
            try:
                taken.bind(("", port))
                return port
            except OSError:
                continue
    return 0
