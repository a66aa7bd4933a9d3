"""One value of each message and the bytes that Python packs of it, as a header for a C++ test."""

import dataclasses
import itertools
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "host/python"))
import stof_wire  # noqa: E402
from wire.table import SIZES, snake  # noqa: E402


def value_of(layout, wire, numbers):
    """An object of Python whose fields all differ."""
    found = {}
    for field in layout.fields:
        if field.reserved or field.value:
            continue
        if field.type == "text":
            found[field.name] = (field.name * 32)[: field.count - 1]
            continue
        one = [value_of(wire.structs[field.struct], wire, numbers) if field.struct else number(field.type, next(numbers))
               for _ in range(field.count)]
        found[field.name] = tuple(one) if field.count > 1 else one[0]
    return getattr(stof_wire, class_name(layout))(**found)


def class_name(layout):
    return "Header" if layout.struct == "HeaderFields" else layout.struct


def number(kind, n):
    bits = 8 * SIZES[kind]
    value = n * 0x9E3779B97F4A7C15 % (1 << bits)
    return value - (1 << bits) if kind[0] == "i" and value >> (bits - 1) else value


def literal(value, field, wire):
    """A C++ initialiser."""
    if isinstance(value, str):
        return "{" + ", ".join(f"'{c}'" for c in value) + "}"
    if isinstance(value, tuple):
        inner = ", ".join(literal(one, field, wire) for one in value)
        return "{{" + inner + "}}"
    if dataclasses.is_dataclass(value):
        return fields_of(value, wire.structs[field.struct], wire)
    if field.enum:
        return f"{field.enum}{{{value}}}"
    if field.type == "i64" and value == -1 << 63:
        return "INT64_MIN"
    return f"{value}{'U' if field.type[0] == 'u' else ''}{'LL' if field.type in ('u64', 'i64') else ''}"


def fields_of(value, layout, wire):
    parts = [f".{field.name} = {literal(getattr(value, field.name), field, wire)}"
             for field in layout.fields if not field.reserved and not field.value]
    return f"{layout.struct}{{{', '.join(parts)}}}"


def text(wire):
    """The header's text: of each message its value and its bytes, and a visit of them all."""
    numbers = itertools.count(1)
    lines = ["#pragma once", "", "#include <array>", ""]
    lines += [f'#include "firmware/wire/messages/{name}.h"' for name in wire.messages]
    lines += ["", "namespace stof::wire::golden {", "", "template <typename T, std::size_t kBytes>",
              "struct Golden {", "  T value;", "  std::array<unsigned char, kBytes> bytes;", "};", ""]
    for name, layout in wire.messages.items():
        value = value_of(layout, wire, numbers)
        packed = ", ".join(str(byte) for byte in value.pack())
        lines += [f"inline const Golden<{layout.struct}, k{layout.struct}Bytes> {name}{{",
                  f"    .value = {fields_of(value, layout, wire)},", f"    .bytes = {{{packed}}}}};", ""]
    lines += ["template <typename Visit>", "void visit_messages(const Visit& visit) {"]
    for name, layout in wire.messages.items():
        codec = snake(layout.struct)
        lines.append(f'  visit("{name}", {name}, encode_{codec}, decode_{codec});')
    return "\n".join([*lines, "}", "", "}  // namespace stof::wire::golden", ""])
