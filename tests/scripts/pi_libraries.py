"""A stand-in for unpacked packages of libcamera and what it is linked with: their layout, and nothing that runs."""

import gzip
import hashlib
import json
import pathlib
import struct

import libcamera  # of scripts/imaging

HEADER, ENTRY = 64, 56  # bytes of an ELF header and of a program header
LIBRARIES = "usr/lib/aarch64-linux-gnu"
# Two primes of 255 and 256 bits: a key whose secret everybody may know.
PRIMES, EXPONENT = (2**255 - 19, 2**256 - 189), 65537


def elf(*needed, interpreter=None, more=b""):
    """A 64-bit ARM program or library that names these libraries."""
    strings = b"\0" + b"".join(name.encode() + b"\0" for name in needed)
    offsets, at = [], 1
    for name in needed:
        offsets.append(at)
        at += len(name) + 1
    kinds = [(1, None), (2, None)] + ([(3, None)] if interpreter else [])
    begin = HEADER + ENTRY * len(kinds)
    path = interpreter.encode() + b"\0" if interpreter else b""
    strings_at = begin + len(path)
    dynamic_at = (strings_at + len(strings) + 15) // 16 * 16
    dynamic = b"".join(struct.pack("<QQ", *entry) for entry in (*((1, offset) for offset in offsets), (5, strings_at), (0, 0)))
    size = dynamic_at + len(dynamic) + len(more)
    places = {1: (0, size), 2: (dynamic_at, len(dynamic)), 3: (begin, len(path))}
    head = struct.pack("<16sHHIQQQIHHHHHH", b"\x7fELF\x02\x01\x01", 3, 183, 1, 0, HEADER, 0, 0, HEADER, ENTRY, len(kinds), 64, 0, 0)
    table = b"".join(struct.pack("<IIQQQQQQ", kind, 4, places[kind][0], places[kind][0], places[kind][0], places[kind][1],
                                 places[kind][1], 8) for kind, _ in kinds)
    return (head + table + path + strings).ljust(dynamic_at, b"\0") + dynamic + more


def _number(value):
    data = value.to_bytes(value.bit_length() // 8 + 1, "big")
    return _der(2, data)


def _der(tag, data):
    return bytes((tag, 0x82)) + len(data).to_bytes(2, "big") + data


def public_key():
    """As libcamera.so holds it: SubjectPublicKeyInfo."""
    numbers = _der(0x30, _number(PRIMES[0] * PRIMES[1]) + _number(EXPONENT))
    return _der(0x30, libcamera.RSA_KEY + _der(3, b"\0" + numbers))


def signature(data):
    modulus = PRIMES[0] * PRIMES[1]
    size = (modulus.bit_length() + 7) // 8
    digest = libcamera.SHA256_OF + hashlib.sha256(data).digest()
    padded = b"\0\1" + b"\xff" * (size - len(digest) - 3) + b"\0" + digest
    secret = pow(EXPONENT, -1, (PRIMES[0] - 1) * (PRIMES[1] - 1))
    return pow(int.from_bytes(padded, "big"), secret, modulus).to_bytes(size, "big")


def make(folder, plan, version="0.4", modules="libcamera"):
    """All of libcamera that the recipe `plan` names, in `folder`; modules: where its modules are. The program, as bytes."""
    folder = pathlib.Path(folder)

    def file(name, data):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)

    own = f"libcamera.so.{version}"
    file(f"{LIBRARIES}/{own}", elf(f"libcamera-base.so.{version}", "libyaml-0.so.2", "libc.so.6", more=public_key()))
    file(f"{LIBRARIES}/libcamera-base.so.{version}", elf("libgnutls.so.30", "libc.so.6"))
    for name in ("libgnutls.so.30", "libyaml-0.so.2"):
        file(f"{LIBRARIES}/{name}", elf("libc.so.6"))
    file(f"{LIBRARIES}/libc.so.6", elf("ld-linux-aarch64.so.1", interpreter="/lib/ld-linux-aarch64.so.1"))
    file("usr/lib/ld-linux-aarch64.so.1", elf())
    for name in plan.libcamera.get("modules", []):
        data = elf(own, "libc.so.6", more=name.encode())
        file(f"{LIBRARIES}/{modules}/{name}", data)
        file(f"{LIBRARIES}/{modules}/{name}.sign", signature(data))
    for name in plan.libcamera.get("files", []):
        file(name, json.dumps({"of": name}).encode())
    for package in (f"libcamera{version}", "libcamera-ipa", "libgnutls30t64", "libyaml-0-2", "libc6"):
        file(f"usr/share/doc/{package}/changelog.Debian.gz", gzip.compress(b"source (1:1-2) stable; urgency=low\n"))
        file(f"usr/share/doc/{package}/copyright", b"see /usr/share/common-licenses/GPL-2.")
    return elf(own, "libc.so.6", interpreter="/lib/ld-linux-aarch64.so.1")
