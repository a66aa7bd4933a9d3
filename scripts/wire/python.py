"""host/python/stof_wire.py: the wire table as a module of plain Python."""

from wire.table import snake

PATH = "host/python/stof_wire.py"
CODES = {"u8": "B", "u16": "H", "u32": "I", "u64": "Q", "i8": "b", "i16": "h", "i32": "i", "i64": "q"}
WIDTH = 100

HEAD = '''"""The wire of a stof sensor: packets to objects and back. Plain Python 3, nothing to install.

header, payload = parse(datagram)        # raises Refused, whose text is the cause
message = MESSAGES[header.type].unpack(payload)  # types that have a message; raises Refused
datagram = seal(Header(type=PacketType.DISCOVER), Discover(request_id=1).pack())

The bytes are those of docs/WIRE.md. Numbers of the enumerations may be unknown: of a newer sensor.

Made by scripts/wire_table.py of firmware/wire/messages.json: change that.
"""

import dataclasses
import enum
import struct
import typing

MAX_DATAGRAM = 1232
CRC_BYTES = 4


class Refused(Exception):
    """Bytes that are not what they should be; the text is the cause."""

'''

BASE = '''
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
            return bytes(values).split(b"\\0")[0].decode("utf-8", "replace")
        return tuple(values) if kind is tuple else values[0]

    def pack(self):
        """Bytes. Raises struct.error where a number does not fit its field."""
        out = bytearray()
        for name, kind, count in self.LAYOUT:
            value = getattr(self, name) if name else None
            if kind == "x":
                out += bytes(count)
            elif isinstance(value, str):
                out += value.encode()[:count].ljust(count, b"\\0")
            else:
                values = value if isinstance(value, tuple) else (value,)
                if len(values) != count:
                    raise struct.error(f"{name}: takes {count} values, not {len(values)}")
                for one in values:
                    out += struct.pack("<" + kind, one) if isinstance(kind, str) else one.pack()
        return bytes(out)

'''

TAIL = '''
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


def seal(header, payload=b""):
    """The datagram of a header and a payload; lengths and CRC are filled in. Raises ValueError."""
    header = dataclasses.replace(header, header_length=Header.size(), payload_length=len(payload))
    packet = header.pack() + payload
    if len(packet) + CRC_BYTES > MAX_DATAGRAM:
        raise ValueError(f"a payload of {len(payload)} bytes does not fit a datagram")
    return packet + crc32c(packet).to_bytes(CRC_BYTES, "little")
'''


def commented(code, doc):
    """`code  # doc`; a doc that does not fit its line stands before it."""
    indent = code[: len(code) - len(code.lstrip())]
    if not doc:
        return [code]
    if len(code) + len(doc) + 4 <= WIDTH:
        return [f"{code}  # {doc}"]
    lines, words = [], f"{indent}#"
    for word in doc.split():
        if len(words) + 1 + len(word) > WIDTH:
            lines.append(words)
            words = f"{indent}#"
        words += " " + word
    return [*lines, words, code]


def enum_text(name, doc, values):
    lines = ["", "", f"class {name}(enum.IntEnum):"]
    if doc:
        lines += [f'    """{doc}"""', ""]
    for value in values:
        lines += commented(f"    {value['name'].upper()} = {value['value']}", value["doc"])
    return lines


def default(field):
    if field.type == "text":
        return 'str = ""'
    if field.count > 1:
        one = f"{field.struct}()" if field.struct else "0"
        return f"tuple = ({one},) * {field.count}"
    if field.struct:
        return f"{field.struct} = dataclasses.field(default_factory={field.struct})"
    return f"int = {field.value or field.default or 0}"


def field_name(layout, field):
    return "" if field.reserved else field.name


def doc_of(field):
    if field.labels:
        return f"{field.labels}: {field.doc}"
    return field.doc


def class_text(layout):
    name = "Header" if layout.struct == "HeaderFields" else layout.struct
    lines = ["", "", "@dataclasses.dataclass", f"class {name}(Layout):"]
    doc = layout.doc.removeprefix("Header: ")
    if doc:
        lines += [f'    """{doc[0].upper()}{doc[1:]}"""' if len(doc) < 88 else
                  "\n".join(['    """' + line[6:] if i == 0 else "    " + line[6:]
                             for i, line in enumerate(commented("    .", doc)[:-1])]) + '"""', ""]
    for field in layout.fields:
        if not field.reserved:
            lines += commented(f"    {field.name}: {default(field)}", doc_of(field))
    lines += ["", "    LAYOUT: typing.ClassVar[tuple] = ("]
    for field in layout.fields:
        if field.reserved:
            lines.append(f'        ("", "x", {field.bytes}),')
        else:
            kind = field.struct or ('"B"' if field.type == "text" else f'"{CODES[field.type]}"')
            lines.append(f'        ("{field.name}", {kind}, {field.count}),')
    return [*lines, "    )"]


def conditions_text(wire):
    lines = enum_text("Condition", "What can be wrong with a sensor: values in events, bits in health.",
                      [{**c, "doc": f"{c['text']}; value: {c['value_doc']}"} for c in wire.conditions])
    lines += ["", "", "class ConditionInfo(typing.NamedTuple):", '    """What a condition means."""', "",
              "    text: str", "    severity: Severity", "    reaction: Reaction  # of the robot while it is active",
              "", "", "CONDITIONS = {"]
    for c in wire.conditions:
        lines += [f"    Condition.{c['name'].upper()}: ConditionInfo(", f'        "{c["text"]}",',
                  f"        Severity.{c['severity'].upper()}, Reaction.{c['reaction'].upper()}),"]
    return [*lines, "}"]


def files(wire):
    """{path: text}"""
    lines = [line for e in wire.enums for line in enum_text(e["name"], e.get("doc", ""), e["values"])]
    lines += conditions_text(wire)
    lines += ["", *BASE.rstrip("\n").split("\n")]
    for layout in (*wire.structs.values(), *wire.messages.values()):
        lines += class_text(layout)
    lines += ["", "", "# The payload of each type that is one message; what follows it is text or data.", "MESSAGES = {"]
    for layout in wire.messages.values():
        lines += [f"    PacketType.{name.upper()}: {layout.struct}," for name in layout.types]
    lines += ["}", ""]
    return {PATH: HEAD.rstrip("\n") + "\n" + "\n".join(lines) + TAIL}
