"""host/wireshark/stof.lua, Wireshark's view of the wire: the table of messages inside it."""

from wire import blocks

PATH = "host/wireshark/stof.lua"
TYPES = {"u8": "uint8", "u16": "uint16", "u32": "uint32", "u64": "uint64",
         "i8": "int8", "i16": "int16", "i32": "int32", "i64": "int64", "text": "string"}


def quoted(text):
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def names_of(name, values):
    lines = [f"names.{name} = {{"]
    lines += [f'  [{v["value"]}] = {quoted(v["name"].replace("_", " "))},' for v in values]
    return [*lines, "}"]


def row(field):
    shown = field.name.replace("_", " ")
    parts = [f"name = {quoted(field.name)}", f"size = {field.size}", f"count = {field.count}"]
    if field.struct:
        return f"  {{{', '.join([*parts, f'layout = {quoted(field.struct)}'])}}},"
    if field.type == "text":
        parts = [parts[0], f"size = {field.bytes}", "count = 1"]
    elif field.reserved:
        parts = [parts[0], f"size = {field.bytes}", "count = 1"]
    kind = "bytes" if field.reserved else TYPES[field.type]
    parts += [f"kind = {quoted(kind)}", f"title = {quoted(shown[0].upper() + shown[1:])}"]
    if kind.startswith(("uint", "int")):
        base = "base.HEX" if field.bits or field.name in ("magic", "cookie", "device_id", "session_id") else "base.DEC"
        parts.append(f"base = {base}")
    if field.labels:
        parts.append(f"names = {quoted(field.labels)}")
    if field.doc:
        parts.append(f"doc = {quoted(field.doc)}")
    return f"  {{{', '.join(parts)}}},"


def layout_text(layout, message):
    lines = [f"layouts.{layout.name if message else layout.struct} = {{"]
    if message:
        lines += [f"  message = {quoted(layout.name.replace('_', ' '))},", f"  bytes = {layout.bytes},"]
    if layout.tail:
        lines.append(f"  tail = {quoted(layout.tail)},")
    for field in layout.fields:
        if field.bits:
            lines += [f"  mask = {field.offset},", f"  mask_names = {quoted(field.bits)},"]
    return [*lines, *map(row, layout.fields), "}"]


def files(wire, root):
    """{path: text}"""
    lines = []
    for enum in wire.enums:
        lines += ["", *names_of(enum["name"], enum["values"])]
    lines += ["", *names_of("Condition", wire.conditions)]
    for layout in wire.structs.values():
        lines += ["", *layout_text(layout, False)]
    for layout in wire.messages.values():
        lines += ["", *layout_text(layout, True)]
    kinds = {v["name"]: v["value"] for e in wire.enums if e["name"] == "PacketType" for v in e["values"]}
    lines += ["", "local payload_of = {"]
    for layout in wire.messages.values():
        lines += [f"  [{kinds[name]}] = {quoted(layout.name)}," for name in layout.types]
    made = {"table": [*lines[1:], "}"]}
    return {PATH: blocks.filled((root / PATH).read_text(encoding="utf-8"), "--", made)}
