"""host/wireshark/stof.lua: Wireshark's view of the wire."""

PATH = "host/wireshark/stof.lua"
TYPES = {"u8": "uint8", "u16": "uint16", "u32": "uint32", "u64": "uint64",
         "i8": "int8", "i16": "int16", "i32": "int32", "i64": "int64", "text": "string"}

HEAD = '''-- The packets of a stof sensor in Wireshark and tshark: docs/WIRE.md.
-- Use: tshark -X lua_script:stof.lua, or copy it into Wireshark's folder of personal Lua plugins.
-- Made by scripts/wire_table.py of firmware/wire/messages.json: change that.

local MAGIC = 0x464f5453
local HEADER_BYTES = 52
local CRC_BYTES = 4
local MAX_DATAGRAM = 1232
local bits = bit or bit32

local stof = Proto("stof", "stof sensor")
local names = {}
local layouts = {}
'''

TAIL = '''
-- The header stands before the payload and ends with it: its layout is the packet's.
local fields = {}
local experts = {
  crc = ProtoExpert.new("stof.bad_crc", "wrong CRC-32C", expert.group.CHECKSUM, expert.severity.ERROR),
  short = ProtoExpert.new("stof.short", "shorter than it says", expert.group.MALFORMED, expert.severity.ERROR),
  long = ProtoExpert.new("stof.long", "longer than it says", expert.group.MALFORMED, expert.severity.ERROR),
  version = ProtoExpert.new("stof.bad_version", "unknown version", expert.group.UNDECODED, expert.severity.WARN),
  field = ProtoExpert.new("stof.bad_index", "packet index not below the count", expert.group.MALFORMED,
                          expert.severity.ERROR),
  unknown = ProtoExpert.new("stof.unknown_type", "unknown type", expert.group.UNDECODED, expert.severity.NOTE),
}

-- Fields of Wireshark: stof.FIELD of the header, stof.MESSAGE.FIELD of a payload.
local function declare(prefix, layout)
  for _, field in ipairs(layout) do
    if field.layout then
      declare(prefix .. field.name .. ".", layouts[field.layout])
    else
      local made = ProtoField[field.kind]
      local key = prefix .. field.name
      if field.kind == "string" then
        fields[key] = made(key, field.title, nil, field.doc)
      elseif field.base then
        fields[key] = made(key, field.title, field.base, names[field.names], nil, field.doc)
      else
        fields[key] = made(key, field.title, field.doc)
      end
    end
  end
end

for name, layout in pairs(layouts) do
  if layout.message then
    declare(name == "header" and "stof." or "stof." .. name .. ".", layout)
  end
end
fields["stof.crc"] = ProtoField.uint32("stof.crc", "CRC-32C", base.HEX)
fields["stof.crc_good"] = ProtoField.bool("stof.crc_good", "CRC is right")
fields["stof.data"] = ProtoField.bytes("stof.data", "Data")
fields["stof.text"] = ProtoField.string("stof.text", "Text")
fields["stof.payload"] = ProtoField.bytes("stof.payload", "Payload")

local listed = {}
for _, field in pairs(fields) do
  listed[#listed + 1] = field
end
stof.fields = listed
local listed_experts = {}
for _, one in pairs(experts) do
  listed_experts[#listed_experts + 1] = one
end
stof.experts = listed_experts

local crc_table = {}
for byte = 0, 255 do
  local crc = byte
  for _ = 1, 8 do
    local low = bits.band(crc, 1)
    crc = bits.rshift(crc, 1)
    if low == 1 then
      crc = bits.bxor(crc, 0x82f63b78)
    end
  end
  crc_table[byte] = crc
end

local function crc32c(range)
  local bytes = range:bytes()
  local crc = 0xffffffff
  for i = 0, bytes:len() - 1 do
    crc = bits.bxor(bits.rshift(crc, 8), crc_table[bits.band(bits.bxor(crc, bytes:get_index(i)), 0xff)])
  end
  return bits.bnot(crc) % 0x100000000
end

-- Adds the fields of a layout that begin at `at`; returns where they end.
local function add(tree, buffer, at, prefix, layout)
  for _, field in ipairs(layout) do
    for _ = 1, field.count do
      if field.layout then
        at = add(tree, buffer, at, prefix .. field.name .. ".", layouts[field.layout])
      else
        tree:add_le(fields[prefix .. field.name], buffer(at, field.size))
        at = at + field.size
      end
    end
  end
  return at
end

-- The names of the bits of a mask, behind a tree's title.
local function add_names(tree, mask, of)
  for bit_number = 0, 31 do
    if bits.band(mask, bits.lshift(1, bit_number)) ~= 0 then
      tree:append_text(string.format(", %s", names[of][bit_number] or "bit " .. bit_number))
    end
  end
end

local function add_payload(tree, header_type, payload)
  local name = payload_of[header_type]
  if not name then
    tree:add(fields["stof.payload"], payload)
    return
  end
  local layout = layouts[name]
  local part = tree:add(payload, layout.message)
  if payload:len() < layout.bytes then
    part:add_proto_expert_info(experts.short)
    return
  end
  local at = add(part, payload, 0, "stof." .. name .. ".", layout)
  if layout.mask then
    add_names(part, payload(layout.mask, 4):le_uint(), layout.mask_names)
  end
  if layout.tail and at < payload:len() then
    part:add(fields["stof." .. layout.tail], payload(at))
  end
end

function stof.dissector(buffer, pinfo, root)
  if buffer:len() < 4 or buffer(0, 4):le_uint() ~= MAGIC then
    return 0
  end
  pinfo.cols.protocol = "STOF"
  local tree = root:add(stof, buffer())
  if buffer:len() < HEADER_BYTES + CRC_BYTES then
    tree:add_proto_expert_info(experts.short)
    return buffer:len()
  end
  add(tree, buffer, 0, "stof.", layouts.header)
  if buffer(4, 1):uint() ~= 1 then
    tree:add_proto_expert_info(experts.version)
    return buffer:len()
  end
  local header_bytes = buffer(6, 1):uint()
  local payload_bytes = buffer(50, 2):le_uint()
  local covered = header_bytes + payload_bytes
  local kind = buffer(5, 1):uint()
  local title = names.PacketType[kind] or "type " .. kind
  pinfo.cols.info = string.format("%s, frame %d, packet %d of %d", title, buffer(20, 4):le_uint(),
                                  buffer(36, 2):le_uint(), buffer(38, 2):le_uint())
  if buffer:len() < covered + CRC_BYTES then
    tree:add_proto_expert_info(experts.short)
    return buffer:len()
  end
  if header_bytes < HEADER_BYTES or buffer:len() > covered + CRC_BYTES or buffer:len() > MAX_DATAGRAM then
    tree:add_proto_expert_info(experts.long)
    return buffer:len()
  end
  local crc = tree:add_le(fields["stof.crc"], buffer(covered, CRC_BYTES))
  local good = crc32c(buffer(0, covered)) == buffer(covered, CRC_BYTES):le_uint()
  crc:add(fields["stof.crc_good"], good):set_generated()
  if not good then
    crc:add_proto_expert_info(experts.crc)
    return buffer:len()
  end
  if buffer(36, 2):le_uint() >= buffer(38, 2):le_uint() then
    tree:add_proto_expert_info(experts.field)
  end
  if not names.PacketType[kind] then
    tree:add_proto_expert_info(experts.unknown)
  end
  if payload_bytes > 0 then
    add_payload(tree, kind, buffer(header_bytes, payload_bytes))
  end
  return buffer:len()
end

local ports = DissectorTable.get("udp.port")
ports:add(7560, stof)
ports:add(7561, stof)
stof:register_heuristic("udp", function(buffer, pinfo, root)
  if buffer:len() < HEADER_BYTES + CRC_BYTES or buffer(0, 4):le_uint() ~= MAGIC then
    return false
  end
  stof.dissector(buffer, pinfo, root)
  return true
end)
'''


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


def files(wire):
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
    return {PATH: HEAD + "\n".join([*lines, "}", ""]) + TAIL}
