"""firmware/wire/messages.json, read and laid out: every field with its offset and size."""

import dataclasses
import json
import re

SIZES = {"u8": 1, "u16": 2, "u32": 4, "u64": 8, "i8": 1, "i16": 2, "i32": 4, "i64": 8, "text": 1}


@dataclasses.dataclass(frozen=True)
class Field:
    name: str
    doc: str
    type: str  # a key of SIZES; "" where `struct` is given
    struct: str  # name of a structure; "" otherwise
    enum: str  # name of the enumeration its values belong to; "" otherwise
    labels: str  # name of the enumeration that names its values for people; "" otherwise
    bits: str  # name of the enumeration that names its bits; "" otherwise
    count: int  # of elements; 1: not an array
    reserved: bool
    value: str  # the only legal value; "" otherwise
    default: str
    offset: int
    size: int  # of one element, bytes

    @property
    def bytes(self):
        return self.size * self.count


@dataclasses.dataclass(frozen=True)
class Layout:
    """A structure or a message: fields one after the other, without gaps."""

    name: str  # snake case
    struct: str  # CamelCase
    doc: str
    fields: tuple[Field, ...]
    compare: bool
    types: tuple[str, ...]  # names of the packet types whose payload it is
    tail: str  # what follows the fields, up to the end of the payload; "" if nothing does

    @property
    def bytes(self):
        return sum(field.bytes for field in self.fields)


@dataclasses.dataclass(frozen=True)
class Wire:
    enums: tuple[dict, ...]
    structs: dict[str, Layout]
    messages: dict[str, Layout]
    conditions: tuple[dict, ...]


def snake(camel):
    return re.sub(r"(?<!^)(?=[A-Z])", "_", camel).lower()


def lay_out(entry, structs):
    fields, offset = [], 0
    for field in entry["fields"]:
        struct = field.get("struct", "")
        size = structs[struct].bytes if struct else SIZES[field["type"]]
        fields.append(Field(
            name=field["name"], doc=field.get("doc", ""), type=field.get("type", ""), struct=struct,
            enum=field.get("enum", ""), labels=field.get("labels", field.get("enum", "")),
            bits=field.get("bits", ""), count=field.get("count", 1), reserved=field.get("reserved", False),
            value=str(field.get("value", "")), default=str(field.get("default", "")), offset=offset, size=size))
        offset += size * field.get("count", 1)
    struct = entry.get("struct", entry["name"])
    return Layout(name=entry["name"] if "struct" in entry else snake(entry["name"]), struct=struct,
                  doc=entry.get("doc", ""), fields=tuple(fields), compare=entry.get("compare", False),
                  types=tuple(entry.get("types", ())), tail=entry.get("tail", ""))


def load(root):
    entries = json.loads((root / "firmware/wire/messages.json").read_text(encoding="utf-8"))
    structs = {}
    for entry in entries["structs"]:
        structs[entry["name"]] = lay_out(entry, structs)
    messages = {entry["name"]: lay_out(entry, structs) for entry in entries["messages"]}
    return Wire(enums=tuple(entries["enums"]), structs=structs, messages=messages,
                conditions=tuple(entries["conditions"]))
