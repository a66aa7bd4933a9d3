"""host/python/stof_wire.py, the wire in plain Python: the enumerations and messages inside it."""

from wire import blocks

PATH = "host/python/stof_wire.py"
CODES = {"u8": "B", "u16": "H", "u32": "I", "u64": "Q", "i8": "b", "i16": "h", "i32": "i", "i64": "q"}
WIDTH = 100


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


def files(wire, root):
    """{path: text}"""
    names = [line for e in wire.enums for line in enum_text(e["name"], e.get("doc", ""), e["values"])]
    names += conditions_text(wire)
    lines = [line for layout in (*wire.structs.values(), *wire.messages.values()) for line in class_text(layout)]
    lines += ["", "", "# The payload of each type that is one message; what follows it is text or data.", "MESSAGES = {"]
    for layout in wire.messages.values():
        lines += [f"    PacketType.{name.upper()}: {layout.struct}," for name in layout.types]
    made = {"enumerations": names[2:], "messages": [*lines[2:], "}"]}  # without the blank lines before them
    return {PATH: blocks.filled((root / PATH).read_text(encoding="utf-8"), "#", made)}
