"""The tables of docs/WIRE.md, between `<!-- table: NAME -->` and `<!-- end -->`."""

import re

PATH = "docs/WIRE.md"
NEW = "<!-- new messages -->\n"  # before it come the sections of messages that have none
BLOCK = re.compile(r"(<!-- table: (\w+) -->\n)(?:(?!<!-- ).*\n)*(<!-- end -->)")


def table(titles, rows):
    """titles: (text, right-aligned)."""
    lines = ["| " + " | ".join(text for text, _ in titles) + " |",
             "| " + " | ".join("---:" if right else "---" for _, right in titles) + " |"]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def enum_table(enum, first):
    return table(((first, True), ("name", False), ("meaning", False)),
                 [(str(v["value"]), v["name"].replace("_", " "), v["doc"]) for v in enum["values"]])


def shown(field):
    return field.name.replace("_", " ")


def type_of(field):
    return ("u8" if field.reserved else field.type) or field.struct


def rows_of(wire, layout, offset=0, before=""):
    rows = []
    for field in layout.fields:
        at, name = offset + field.offset, before + shown(field)
        if field.struct and field.count == 1:
            rows += rows_of(wire, wire.structs[field.struct], at)
        elif field.struct:
            parts = "; ".join(f"{type_of(part)} {shown(part)}: {part.doc}"
                              for part in wire.structs[field.struct].fields)
            rows.append((str(at), f"{field.count} x {field.size}", "", name, f"{field.doc}. Each {parts}"))
        elif field.reserved:
            rows.append((str(at), str(field.bytes), "", "reserved", ""))
        elif field.type == "text":
            rows.append((str(at), str(field.bytes), "text", name, field.doc))
        else:
            size = f"{field.count} x {field.size}" if field.count > 1 else str(field.size)
            rows.append((str(at), size, type_of(field), name, field.doc))
    return rows


def layout_table(wire, layout):
    rows = rows_of(wire, layout)
    if layout.name == "header":
        rows += [("H", "P", "", "payload", ""),
                 ("H + P", "4", "u32", "CRC", "CRC-32C of all H + P bytes before it")]
    elif layout.tail:
        rows.append((str(layout.bytes), "the rest", "", layout.tail, "up to the end of the payload"))
    text = table((("offset", True), ("bytes", True), ("type", False), ("field", False), ("meaning", False)), rows)
    if layout.name == "header":
        return text
    if not layout.types:
        return f"Of {layout.bytes} bytes.\n\n{text}"
    if layout.tail:
        return f"Payload of {layout.bytes} bytes and {layout.tail}.\n\n{text}"
    return f"Payload of {layout.bytes} bytes; ignore what follows them.\n\n{text}"


def conditions_table(wire):
    return table((("bit", True), ("condition", False), ("severity", False), ("robot", False),
                  ("meaning", False), ("value", False)),
                 [(str(c["value"]), c["name"].replace("_", " "), c["severity"], c["reaction"], c["text"],
                   c["value_doc"]) for c in wire.conditions])


def tables(wire):
    """{name: text}"""
    first = {"PacketType": "type", "Stream": "stream", "Codec": "codec", "SubscribeResult": "result",
             "SettingsResult": "result", "SettingsOperation": "operation", "SettingsDocument": "document"}
    found = {enum["name"]: enum_table(enum, first.get(enum["name"], "value")) for enum in wire.enums}
    found |= {name: layout_table(wire, layout) for name, layout in wire.messages.items()}
    found["conditions"] = conditions_table(wire)
    return found


def filled(text, found):
    """The document with every table as it should be. KeyError: a marker that names no table."""
    return BLOCK.sub(lambda match: f"{match[1]}{found[match[2]]}\n{match[3]}", text)


def section(layout):
    title = shown(layout).capitalize()
    return f"## {title}\n\n{layout.doc}\n\n<!-- table: {layout.name} -->\n<!-- end -->\n\n"


def with_sections(text, wire):
    known = {match[2] for match in BLOCK.finditer(text)}
    missing = "".join(section(layout) for name, layout in wire.messages.items() if name not in known)
    return text.replace(NEW, missing + NEW)


def files(wire, root):
    """{path: text}"""
    text = (root / PATH).read_text(encoding="utf-8")
    return {PATH: filled(with_sections(text, wire), tables(wire))}
