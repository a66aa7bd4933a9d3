"""The C++ of the wire table: one header and one source a message, as if below firmware/wire/messages."""

from wire.table import snake

FOLDER = "firmware/wire/messages"
BANNER = "// Made by the build of firmware/wire/messages.json: change that."
TYPES = {"u8": "std::uint8_t", "u16": "std::uint16_t", "u32": "std::uint32_t", "u64": "std::uint64_t",
         "i8": "std::int8_t", "i16": "std::int16_t", "i32": "std::int32_t", "i64": "std::int64_t",
         "text": "char"}
MANY_MEMBERS = 15  # more need a reason beside them
BITS = {"u8": "u8", "u16": "u16", "u32": "u32", "u64": "u64", "i32": "i32", "i64": "i64"}


def camel(name):
    return "".join(part.capitalize() for part in name.split("_"))


def constant(struct):
    return f"k{struct}Bytes"


def member_type(field):
    base = field.struct or field.enum or TYPES[field.type]
    return f"std::array<{base}, {field.count}>" if field.count > 1 else base


def member(field):
    initial = f" = {field.enum}{{}}" if field.enum else (f" = {field.default or 0}" if field.type and field.count == 1 else "{}")
    return f"  {member_type(field)} {field.name}{initial};  // {field.doc or snake(field.struct)}"


def visible(layout):
    return [field for field in layout.fields if not field.reserved and not field.value]


def struct_text(layout):
    lines = [f"inline constexpr std::size_t {constant(layout.struct)} = {layout.bytes};", ""]
    if layout.doc:
        lines.append(f"// {layout.doc}")
    members = visible(layout)
    if len(members) > MANY_MEMBERS:
        lines.append("// It mirrors a message of the wire: a member for each field.")
    lines += [f"struct {layout.struct} {{", *map(member, members)]
    if layout.compare:
        lines += ["", f"  friend bool operator==(const {layout.struct}&, const {layout.struct}&) = default;"]
    lines += ["};", ""]
    return lines


def element(field, value, put):
    """Statement or expression for one element, `{at}` to be replaced by its span."""
    if field.struct:
        return f"put_{snake(field.struct)}({{at}}, {value});" if put else f"get_{snake(field.struct)}({{at}})"
    if field.type == "text":
        return f"put_u8({{at}}, static_cast<std::uint8_t>({value}));" if put else "static_cast<char>(get_u8({at}))"
    bits = BITS[field.type]
    if field.enum:
        return f"put_{bits}({{at}}, static_cast<std::uint8_t>({value}));" if put else f"{field.enum}{{{{get_{bits}({{at}})}}}}"
    return f"put_{bits}({{at}}, {value});" if put else f"get_{bits}({{at}})"


def fixed(buffer, field):
    return f"{buffer}.subspan<{field.offset}, {field.size}>()"


def indexed(buffer, field):
    return f"{buffer}.subspan({field.offset} + {field.size} * i).first<{field.size}>()"


def writes(layout):
    lines = []
    for field in layout.fields:
        if field.reserved:
            lines.append(f"std::ranges::fill(out.subspan<{field.offset}, {field.bytes}>(), std::byte{{0}});")
        elif field.value:
            lines.append(f"put_{BITS[field.type]}({fixed('out', field)}, {field.value});")
        elif field.count > 1:
            statement = element(field, f"value.{field.name}[i]", True).format(at=indexed("out", field))
            lines.append(f"for (std::size_t i = 0; i < {field.count}; ++i) {{ {statement} }}")
        else:
            lines.append(element(field, f"value.{field.name}", True).format(at=fixed("out", field)))
    return lines


def reads(layout):
    lines = [f"{layout.struct} value;"]
    for field in visible(layout):
        if field.count > 1:
            expression = element(field, "", False).format(at=indexed("in", field))
            lines.append(f"for (std::size_t i = 0; i < {field.count}; ++i) {{ value.{field.name}[i] = {expression}; }}")
        else:
            lines.append(f"value.{field.name} = {element(field, '', False).format(at=fixed('in', field))};")
    return [*lines, "return value;"]


def indented(lines):
    return [f"  {line}" for line in lines]


def declarations(layout, nested):
    name = snake(layout.struct)
    span = f"std::span<std::byte, {constant(layout.struct)}>"
    from_span = f"std::span<const std::byte, {constant(layout.struct)}>"
    if nested:
        return [f"void put_{name}({span} out, const {layout.struct}& value) noexcept;",
                f"{layout.struct} get_{name}({from_span} in) noexcept;"]
    return [f"void encode_{name}(const {layout.struct}& value, {span} out) noexcept;",
            f"// kCorrupt: shorter than {constant(layout.struct)}. What follows is of a newer sender and ignored.",
            f"Result<{layout.struct}> decode_{name}(std::span<const std::byte> payload) noexcept;"]


def definitions(layout, nested):
    name, size = snake(layout.struct), constant(layout.struct)
    put_head, get_head = [line.rstrip(";") for line in declarations(layout, nested) if not line.startswith("//")]
    if nested:
        return [f"{put_head} {{", *indented(writes(layout)), "}", "", f"{get_head} {{", *indented(reads(layout)), "}", ""]
    return [f"{put_head} {{", *indented(writes(layout)), "}", "", f"{get_head} {{",
            *indented([f"if (payload.size() < {size}) {{ return fail(Status::kCorrupt); }}",
                       f"const std::span<const std::byte, {size}> in = payload.first<{size}>();", *reads(layout)]),
            "}", ""]


def header_text(includes, body):
    lines = [BANNER, "#pragma once", "", *(f"#include <{name}>" for name in ("array", "cstddef", "cstdint", "span")),
             "", *(f'#include "{name}"' for name in includes), "", "namespace stof::wire {", "", *body,
             "", "}  // namespace stof::wire", ""]
    return "\n".join(lines)


def source_text(own, body):
    return "\n".join([BANNER, f'#include "{own}"', "", "#include <algorithm>", "",
                      '#include "firmware/wire/bytes.h"', "", "namespace stof::wire {", "", *body,
                      "}  // namespace stof::wire", ""])


def enums_text(wire):
    lines = [BANNER, "#pragma once", "", "#include <cstdint>", "", "namespace stof::wire {", "",
             "// Enumerations hold what arrived: a value without a name is legal and means \"newer than this code\".",
             "// It is ignored and counted, never an error.", ""]
    for enum in wire.enums:
        lines.append(f"enum class {enum['name']} : std::uint8_t {{")
        lines += [f"  k{camel(value['name'])} = {value['value']},  // {value['doc']}" for value in enum["values"]]
        lines += ["};", ""]
    return "\n".join([*lines, "}  // namespace stof::wire", ""])


def conditions_text(wire):
    """What can be wrong with a sensor: (header, source)."""
    header = [f"inline constexpr std::size_t kConditions = {len(wire.conditions)};", "",
              "// What can be wrong; values travel in events and, as bits, in health.",
              "enum class Condition : std::uint8_t {"]
    header += [f"  k{camel(c['name'])} = {c['value']},  // {c['text']}; value: {c['value_doc']}" for c in wire.conditions]
    header += ["};", "", "struct ConditionInfo {", "  const char* name;  // snake case", "  const char* text;  // for people",
               "  Severity severity;", "  Reaction reaction;  // of the robot while it is active", "};", "",
               "// nullptr: a condition this code does not know.",
               "const ConditionInfo* info_of(Condition condition) noexcept;"]
    rows = [f'{{"{c["name"]}", "{c["text"]}", Severity::k{camel(c["severity"])}, Reaction::k{camel(c["reaction"])}}},'
            for c in wire.conditions]
    source = ["namespace {", "", "constexpr std::array<ConditionInfo, kConditions> kInfos{{", *indented(rows), "}};", "",
              "}  // namespace", "",
              "const ConditionInfo* info_of(Condition condition) noexcept {",
              "  const auto at = static_cast<std::size_t>(condition);",
              "  return at < kInfos.size() ? &kInfos[at] : nullptr;", "}", ""]
    return header_text(["firmware/wire/messages/enums.h"], header), "\n".join(
        [BANNER, f'#include "{FOLDER}/conditions.h"', "", "namespace stof::wire {", "", *source,
         "}  // namespace stof::wire", ""])


def files(wire):
    """{path: text}"""
    enums, structs, dsp = f"{FOLDER}/enums.h", f"{FOLDER}/structs.h", "dsp/base/status.h"
    found = {enums: enums_text(wire)}
    found[f"{FOLDER}/conditions.h"], found[f"{FOLDER}/conditions.cpp"] = conditions_text(wire)
    nested = wire.structs.values()
    found[structs] = header_text([enums], [line for s in nested for line in (*struct_text(s), *declarations(s, True), "")])
    found[f"{FOLDER}/structs.cpp"] = source_text(structs, [line for s in nested for line in definitions(s, True)])
    for message in wire.messages.values():
        own = f"{FOLDER}/{message.name}.h"
        found[own] = header_text([dsp, enums, structs], [*struct_text(message), *declarations(message, False)])
        found[f"{FOLDER}/{message.name}.cpp"] = source_text(own, definitions(message, False))
    return found
