-- The packets of a stof sensor in Wireshark and tshark: docs/WIRE.md.
-- Use: tshark -X lua_script:stof.lua, or copy it into Wireshark's folder of personal Lua plugins.

local MAGIC = 0x464f5453
local HEADER_BYTES = 52
local CRC_BYTES = 4
local MAX_DATAGRAM = 1232
local bits = bit or bit32

local stof = Proto("stof", "stof sensor")
local names = {}
local layouts = {}

-- made: table (by scripts/wire_table.py, of firmware/wire/messages.json: change that)
names.PacketType = {
  [1] = "tile",
  [2] = "frame info",
  [64] = "calibration",
  [65] = "health",
  [66] = "parity",
  [67] = "event",
  [68] = "announce",
  [69] = "sectors",
  [70] = "raw info",
  [71] = "raw tile",
  [128] = "subscribe",
  [129] = "subscribed",
  [130] = "unsubscribe",
  [132] = "settings request",
  [133] = "settings answer",
  [134] = "discover",
  [136] = "signed request",
  [137] = "signed answer",
  [138] = "pair request",
  [139] = "pair answer",
}

names.Stream = {
  [0] = "none",
  [1] = "depth",
  [2] = "width",
  [3] = "source",
  [4] = "disparity",
  [5] = "pmd raw",
  [6] = "grey left",
  [7] = "grey right",
  [8] = "cloud",
  [16] = "raw left",
  [17] = "raw right",
  [18] = "raw pmd",
}

names.Codec = {
  [0] = "none",
  [1] = "raw16",
  [2] = "raw8",
  [3] = "rvl16",
  [4] = "rvl8",
  [5] = "points",
}

names.Health = {
  [0] = "ok",
  [1] = "degraded",
  [2] = "fault",
}

names.ClockState = {
  [0] = "monotonic",
  [1] = "emulated",
  [2] = "recorded",
}

names.Severity = {
  [0] = "info",
  [1] = "minor",
  [2] = "major",
  [3] = "critical",
}

names.Reaction = {
  [0] = "none",
  [1] = "watch",
  [2] = "slow",
  [3] = "stop",
}

names.SubscribeResult = {
  [0] = "ok",
  [1] = "cookie",
  [2] = "full",
  [3] = "ended",
  [4] = "unknown key",
  [5] = "stale",
  [6] = "raw denied",
  [7] = "raw taken",
}

names.SettingsOperation = {
  [0] = "get",
  [1] = "set",
  [2] = "stage",
  [3] = "commit",
  [4] = "revert",
  [5] = "preset",
  [6] = "save",
  [7] = "reset",
  [8] = "keys",
  [9] = "unpair",
  [10] = "upload",
  [11] = "download",
}

names.SettingsDocument = {
  [0] = "active",
  [1] = "staged",
  [2] = "saved",
  [3] = "defaults",
  [4] = "schema",
  [5] = "network",
}

names.Role = {
  [0] = "none",
  [1] = "view",
  [2] = "tune",
  [3] = "admin",
}

names.PairStep = {
  [0] = "begin",
  [1] = "reveal",
  [2] = "confirm",
  [3] = "open",
  [4] = "accept",
}

names.PairMethod = {
  [0] = "digits",
  [1] = "code",
  [2] = "cable",
  [3] = "key",
}

names.PairResult = {
  [0] = "ok",
  [1] = "cookie",
  [2] = "closed",
  [3] = "busy",
  [4] = "wrong",
  [5] = "waiting",
  [6] = "full",
  [7] = "later",
}

names.UploadStep = {
  [0] = "begin",
  [1] = "chunk",
  [2] = "commit",
  [3] = "revert",
  [4] = "ask",
}

names.UploadKind = {
  [1] = "calibration",
  [2] = "update",
}

names.SensorState = {
  [0] = "measuring",
  [1] = "standby",
}

names.UploadState = {
  [0] = "settled",
  [1] = "on trial",
  [2] = "restarting",
  [3] = "left",
}

names.SettingsResult = {
  [0] = "ok",
  [1] = "cookie",
  [2] = "invalid",
  [3] = "not saved",
  [4] = "unsupported",
  [5] = "busy",
  [6] = "denied",
  [7] = "unknown key",
  [8] = "stale",
}

names.Condition = {
  [0] = "no frames",
  [1] = "trigger lost",
  [2] = "stereo lost",
  [3] = "pmd lost",
  [4] = "late",
  [5] = "link lost",
  [6] = "unreachable",
  [7] = "link full",
  [8] = "drift",
  [9] = "serial lost",
  [10] = "serial full",
  [11] = "settings unsaved",
  [12] = "restart needed",
  [13] = "flooded",
  [14] = "settings fell back",
  [15] = "stereo silent",
  [16] = "stereo frozen",
  [17] = "pmd silent",
  [18] = "pmd frozen",
  [19] = "pmd dark",
  [20] = "settings dropped",
  [21] = "connection replaced",
  [22] = "no depth",
  [23] = "settings changed",
  [24] = "unpaired",
  [25] = "keys lost",
  [26] = "pairing",
  [27] = "keys changed",
  [28] = "stereo blind",
  [29] = "calibration changed",
  [30] = "calibration dropped",
  [31] = "release on trial",
}

layouts.RawRequest = {
  {name = "pictures", size = 1, count = 1, kind = "uint8", title = "Pictures", base = base.DEC, doc = "raw pictures that are asked for, the sum of: 1 the left camera's, 2 the right one's, 4 the PMD camera's samples; 8: only exposures that have all of these; 16: the sensor begins anew all that counts from frame to frame. 0: none; see \"Raw pictures\""},
  {name = "step", size = 1, count = 1, kind = "uint8", title = "Step", base = base.DEC, doc = "of the pair: one column and one row of so many is sent; 0: each, as 1"},
  {name = "every", size = 2, count = 1, kind = "uint16", title = "Every", base = base.DEC, doc = "one exposure of so many frames, the next that there is; 0: each, as 1"},
  {name = "column", size = 2, count = 1, kind = "uint16", title = "Column", base = base.DEC, doc = "of the pair: first column of the part that is sent, pixels of the camera"},
  {name = "row", size = 2, count = 1, kind = "uint16", title = "Row", base = base.DEC, doc = "first row"},
  {name = "width", size = 2, count = 1, kind = "uint16", title = "Width", base = base.DEC, doc = "columns of it; 0: all that follow"},
  {name = "height", size = 2, count = 1, kind = "uint16", title = "Height", base = base.DEC, doc = "rows; 0: all that follow"},
}

layouts.Window = {
  {name = "begin_ns", size = 8, count = 1, kind = "int64", title = "Begin ns", base = base.DEC, doc = "begin, ns"},
  {name = "end_ns", size = 8, count = 1, kind = "int64", title = "End ns", base = base.DEC, doc = "end, ns"},
}

layouts.Origin = {
  {name = "device_id", size = 4, count = 1, kind = "uint32", title = "Device id", base = base.HEX, doc = "of the sensor; in requests the one that is meant, 0: any"},
  {name = "session_id", size = 4, count = 1, kind = "uint32", title = "Session id", base = base.HEX, doc = "random, another one at each start of the sender; in requests ignored"},
}

layouts.LoopCounters = {
  {name = "edges", size = 8, count = 1, kind = "uint64", title = "Edges", base = base.DEC, doc = "trigger edges since the sender's start, as all counters that follow"},
  {name = "frames_published", size = 8, count = 1, kind = "uint64", title = "Frames published", base = base.DEC, doc = "frames published"},
  {name = "mispaired", size = 8, count = 1, kind = "uint64", title = "Mispaired", base = base.DEC, doc = "exposures that did not belong to one edge, not published"},
  {name = "timeouts", size = 8, count = 1, kind = "uint64", title = "Timeouts", base = base.DEC, doc = "of cameras"},
  {name = "deadline_misses", size = 8, count = 1, kind = "uint64", title = "Deadline misses", base = base.DEC, doc = "periods skipped and frames too old to publish"},
  {name = "link_drops", size = 8, count = 1, kind = "uint64", title = "Link drops", base = base.DEC, doc = "datagrams that the link did not take"},
}

layouts.DriftReading = {
  {name = "value", size = 4, count = 1, kind = "int32", title = "Value", base = base.DEC, doc = "see \"Drift\" for the unit"},
  {name = "sigma", size = 4, count = 1, kind = "int32", title = "Sigma", base = base.DEC, doc = "standard deviation; 2^31 - 1: unknown"},
}

layouts.ControlCounters = {
  {name = "accepted", size = 8, count = 1, kind = "uint64", title = "Accepted", base = base.DEC, doc = "requests that were served, since the sender's start, as all that follow"},
  {name = "truncated", size = 8, count = 1, kind = "uint64", title = "Truncated", base = base.DEC, doc = "refused: cut short"},
  {name = "bad_magic", size = 8, count = 1, kind = "uint64", title = "Bad magic", base = base.DEC, doc = "refused: not a packet of ours"},
  {name = "bad_version", size = 8, count = 1, kind = "uint64", title = "Bad version", base = base.DEC, doc = "refused: of another version"},
  {name = "bad_length", size = 8, count = 1, kind = "uint64", title = "Bad length", base = base.DEC, doc = "refused: longer than it says"},
  {name = "bad_crc", size = 8, count = 1, kind = "uint64", title = "Bad crc", base = base.DEC, doc = "refused: damaged"},
  {name = "bad_field", size = 8, count = 1, kind = "uint64", title = "Bad field", base = base.DEC, doc = "refused: contradicts itself"},
  {name = "not_control", size = 8, count = 1, kind = "uint64", title = "Not control", base = base.DEC, doc = "refused: of a type that a sensor does not take"},
  {name = "foreign", size = 8, count = 1, kind = "uint64", title = "Foreign", base = base.DEC, doc = "refused: for another device"},
  {name = "too_short", size = 8, count = 1, kind = "uint64", title = "Too short", base = base.DEC, doc = "refused: shorter than its answer could be, from a source that was not validated"},
  {name = "cookies", size = 8, count = 1, kind = "uint64", title = "Cookies", base = base.DEC, doc = "answered with a cookie only: the source was not validated"},
  {name = "busy", size = 8, count = 1, kind = "uint64", title = "Busy", base = base.DEC, doc = "refused: more requests at once than the sensor queues"},
  {name = "overrun", size = 8, count = 1, kind = "uint64", title = "Overrun", base = base.DEC, doc = "lost before they were read: the socket's buffer was full"},
  {name = "forged", size = 8, count = 1, kind = "uint64", title = "Forged", base = base.DEC, doc = "refused: signed with no key that is known here"},
  {name = "replayed", size = 8, count = 1, kind = "uint64", title = "Replayed", base = base.DEC, doc = "refused: signed, but its counter is no higher than one before"},
}

layouts.header = {
  message = "header",
  bytes = 52,
  {name = "magic", size = 4, count = 1, kind = "uint32", title = "Magic", base = base.HEX, doc = "`53 54 4f 46`, \"STOF\""},
  {name = "version", size = 1, count = 1, kind = "uint8", title = "Version", base = base.DEC, doc = "1. A receiver refuses every other value"},
  {name = "type", size = 1, count = 1, kind = "uint8", title = "Type", base = base.DEC, names = "PacketType", doc = "see \"Types\""},
  {name = "header_length", size = 1, count = 1, kind = "uint8", title = "Header length", base = base.DEC, doc = "H, offset of the payload: 52 in this version. A larger one is legal: skip what lies between 52 and H"},
  {name = "flags", size = 1, count = 1, kind = "uint8", title = "Flags", base = base.DEC, doc = "bits 0 to 3: scale of a tile of depth or width (see \"Tiles\"), else 0. Bit 4: a tile of source is told in steps. Bits 5 to 7 are reserved"},
  {name = "origin", size = 8, count = 1, layout = "Origin"},
  {name = "stream", size = 1, count = 1, kind = "uint8", title = "Stream", base = base.DEC, names = "Stream", doc = "see \"Streams\"; 0 outside tiles"},
  {name = "codec", size = 1, count = 1, kind = "uint8", title = "Codec", base = base.DEC, names = "Codec", doc = "see \"Streams\"; 0 outside tiles"},
  {name = "health", size = 1, count = 1, kind = "uint8", title = "Health", base = base.DEC, names = "Health", doc = "summary of the sensor: 0 good, 1 degraded, 2 fault"},
  {name = "clock", size = 1, count = 1, kind = "uint8", title = "Clock", base = base.DEC, names = "ClockState", doc = "what times count from: 0 the sensor's own monotonic clock, synchronised with nothing; 1 the time of an emulated rig"},
  {name = "number", size = 4, count = 1, kind = "uint32", title = "Number", base = base.DEC, doc = "of the frame: advances by one with each frame sent, wraps from 2^32 - 1 to 0"},
  {name = "exposure_middle_ns", size = 8, count = 1, kind = "int64", title = "Exposure middle ns", base = base.DEC, doc = "ns: middle of the exposure of the stereo pair; of the PMD camera in a frame of it alone"},
  {name = "freshness", size = 4, count = 1, kind = "uint32", title = "Freshness", base = base.DEC, doc = "see \"Freshness\""},
  {name = "index", size = 2, count = 1, kind = "uint16", title = "Index", base = base.DEC, doc = "of the packet, from 0, below the count"},
  {name = "count", size = 2, count = 1, kind = "uint16", title = "Count", base = base.DEC, doc = "packets of the frame, at least 1"},
  {name = "image_width", size = 2, count = 1, kind = "uint16", title = "Image width", base = base.DEC, doc = "pixels, of the whole image of the stream; outside tiles of the depth image"},
  {name = "image_height", size = 2, count = 1, kind = "uint16", title = "Image height", base = base.DEC, doc = "rows, likewise"},
  {name = "first_row", size = 2, count = 1, kind = "uint16", title = "First row", base = base.DEC, doc = "of a tile; 0 in other types, as the next two"},
  {name = "first_column", size = 2, count = 1, kind = "uint16", title = "First column", base = base.DEC, doc = "of a tile"},
  {name = "pixel_count", size = 2, count = 1, kind = "uint16", title = "Pixel count", base = base.DEC, doc = "of a tile"},
  {name = "payload_length", size = 2, count = 1, kind = "uint16", title = "Payload length", base = base.DEC, doc = "P"},
}

layouts.frame_info = {
  message = "frame info",
  bytes = 256,
  {name = "exposure_begin_ns", size = 8, count = 1, kind = "int64", title = "Exposure begin ns", base = base.DEC, doc = "begin of the stereo exposure, of the PMD camera's in a frame of it alone; ns, same clock as the header"},
  {name = "exposure_end_ns", size = 8, count = 1, kind = "int64", title = "Exposure end ns", base = base.DEC, doc = "end of it"},
  {name = "pmd_age_ns", size = 8, count = 1, kind = "int64", title = "Pmd age ns", base = base.DEC, doc = "age of the PMD data, ns: exposure middle of the stereo pair less that of the PMD data; 0 without either"},
  {name = "compute_ns", size = 8, count = 1, kind = "int64", title = "Compute ns", base = base.DEC, doc = "what the frame took to compute, ns"},
  {name = "latency_ns", size = 8, count = 1, kind = "int64", title = "Latency ns", base = base.DEC, doc = "from the exposure middle to the sending of this packet, ns"},
  {name = "pixels_by_source", size = 4, count = 6, kind = "uint32", title = "Pixels by source", base = base.DEC, doc = "pixels by source: none, stereo, PMD, both, resolved, conflict"},
  {name = "counters", size = 48, count = 1, layout = "LoopCounters"},
  {name = "pixels_by_cause", size = 4, count = 6, kind = "uint32", title = "Pixels by cause", base = base.DEC, doc = "pixels by cause, as in \"Causes\""},
  {name = "drifts", size = 8, count = 5, layout = "DriftReading"},
  {name = "drift_patches", size = 4, count = 1, kind = "uint32", title = "Drift patches", base = base.DEC, doc = "patches of the picture that the drifts are known from"},
  {name = "drift_significant", size = 4, count = 1, kind = "uint32", title = "Drift significant", base = base.DEC, doc = "bit k: drift k is significant; calibrate the rig anew"},
  {name = "tiles", size = 2, count = 8, kind = "uint16", title = "Tiles", base = base.DEC, doc = "tiles of streams 1 to 8 in this frame; 0 = not sent"},
  {name = "pmd_present", size = 1, count = 1, kind = "uint8", title = "Pmd present", base = base.DEC, doc = "1: PMD data took part in this frame, 0: not"},
  {name = "parity_groups", size = 1, count = 1, kind = "uint8", title = "Parity groups", base = base.DEC, doc = "packets of parity that go with this frame, 255: so many or more; 0: none"},
  {name = "cloud_step", size = 1, count = 1, kind = "uint8", title = "Cloud step", base = base.DEC, doc = "side of a cloud's block, px; 0: no cloud"},
  {name = "sensors", size = 1, count = 1, kind = "uint8", title = "Sensors", base = base.DEC, doc = "that this frame stands on, the sum of: 1 the stereo pair, 2 the PMD camera; see \"Sensors of a frame\""},
  {name = "settings_revision", size = 4, count = 1, kind = "uint32", title = "Settings revision", base = base.DEC, doc = "of the settings this frame was made with: advances with every change"},
  {name = "stage_us", size = 4, count = 6, kind = "uint32", title = "Stage us", base = base.DEC, doc = "what each stage took, us: convert, match, fuse, watch; of the frame before: code, send (without the waits of pacing)"},
  {name = "steady_frames", size = 4, count = 1, kind = "uint32", title = "Steady frames", base = base.DEC, doc = "frames in a row that this depth stands on, itself included: for how many the camera stood; 1: it stands alone, as each of the PMD camera alone does"},
  {name = "settings_fingerprint", size = 4, count = 1, kind = "uint32", title = "Settings fingerprint", base = base.DEC, doc = "CRC-32C of the document of the settings this frame was made with, see \"Settings\"; 0: not told"},
  {name = "calibration_fingerprint", size = 4, count = 1, kind = "uint32", title = "Calibration fingerprint", base = base.DEC, doc = "of the calibration this frame was made with, as in its message: the frame goes with no other one; 0: not told"},
  {name = "max_range_um", size = 4, count = 1, kind = "uint32", title = "Max range um", base = base.DEC, doc = "maximal range that this frame was made with, um; 0: not told"},
  {name = "period_ns", size = 8, count = 1, kind = "int64", title = "Period ns", base = base.DEC, doc = "of the trigger, that this frame was made with, ns; 0: not told"},
}

layouts.calibration = {
  message = "calibration",
  bytes = 120,
  {name = "image_width", size = 2, count = 1, kind = "uint16", title = "Image width", base = base.DEC, doc = "pixels"},
  {name = "image_height", size = 2, count = 1, kind = "uint16", title = "Image height", base = base.DEC, doc = "rows"},
  {name = "pmd_width", size = 2, count = 1, kind = "uint16", title = "Pmd width", base = base.DEC, doc = "pixels; 0: no PMD camera"},
  {name = "pmd_height", size = 2, count = 1, kind = "uint16", title = "Pmd height", base = base.DEC, doc = "rows"},
  {name = "fx", size = 4, count = 1, kind = "int32", title = "Fx", base = base.DEC, doc = "1/65536 px, of the rectified left camera, in which depth is Z"},
  {name = "fy", size = 4, count = 1, kind = "int32", title = "Fy", base = base.DEC, doc = "1/65536 px"},
  {name = "cx", size = 4, count = 1, kind = "int32", title = "Cx", base = base.DEC, doc = "1/65536 px"},
  {name = "cy", size = 4, count = 1, kind = "int32", title = "Cy", base = base.DEC, doc = "1/65536 px"},
  {name = "doff", size = 4, count = 1, kind = "int32", title = "Doff", base = base.DEC, doc = "1/65536 px: cx of the right camera less that of the left"},
  {name = "depth_unit_um", size = 4, count = 1, kind = "uint32", title = "Depth unit um", base = base.DEC, doc = "of one step of depth and width, micrometres"},
  {name = "max_range", size = 4, count = 1, kind = "uint32", title = "Max range", base = base.DEC, doc = "maximal range, depth units"},
  {name = "modulation_hz", size = 4, count = 1, kind = "uint32", title = "Modulation hz", base = base.DEC, doc = "PMD modulation frequency, Hz"},
  {name = "baseline_nm", size = 8, count = 1, kind = "int64", title = "Baseline nm", base = base.DEC, doc = "nm"},
  {name = "period_ns", size = 8, count = 1, kind = "int64", title = "Period ns", base = base.DEC, doc = "of the trigger, ns"},
  {name = "rotation", size = 4, count = 9, kind = "int32", title = "Rotation", base = base.DEC, doc = "R, row by row, 2^-30"},
  {name = "fingerprint", size = 4, count = 1, kind = "uint32", title = "Fingerprint", base = base.DEC, doc = "of the calibration: the CRC-32C at the end of its file; 0: not told"},
  {name = "translation_nm", size = 8, count = 3, kind = "int64", title = "Translation nm", base = base.DEC, doc = "T, nm"},
}

layouts.health = {
  message = "health",
  bytes = 236,
  mask = 8,
  mask_names = "Condition",
  {name = "uptime_ms", size = 8, count = 1, kind = "uint64", title = "Uptime ms", base = base.DEC, doc = "since the sender's start, ms"},
  {name = "active", size = 4, count = 1, kind = "uint32", title = "Active", base = base.HEX, doc = "bit k: condition k of \"Events\" is active"},
  {name = "severity", size = 1, count = 1, kind = "uint8", title = "Severity", base = base.DEC, names = "Severity", doc = "the highest of them"},
  {name = "reaction", size = 1, count = 1, kind = "uint8", title = "Reaction", base = base.DEC, names = "Reaction", doc = "what the robot should do"},
  {name = "subscribers", size = 1, count = 1, kind = "uint8", title = "Subscribers", base = base.DEC, doc = "that the streams go to now"},
  {name = "reserved", size = 1, count = 1, kind = "bytes", title = "Reserved"},
  {name = "rate_millihertz", size = 4, count = 1, kind = "uint32", title = "Rate millihertz", base = base.DEC, doc = "frames of the last second, 1/1000 Hz"},
  {name = "latency_us", size = 4, count = 1, kind = "uint32", title = "Latency us", base = base.DEC, doc = "mean of the last second: exposure middle to the sending of the last packet, us"},
  {name = "longest_latency_us", size = 4, count = 1, kind = "uint32", title = "Longest latency us", base = base.DEC, doc = "longest of the last second, us"},
  {name = "settings_revision", size = 4, count = 1, kind = "uint32", title = "Settings revision", base = base.DEC, doc = "as in the frame info"},
  {name = "counters", size = 48, count = 1, layout = "LoopCounters"},
  {name = "packets_sent", size = 8, count = 1, kind = "uint64", title = "Packets sent", base = base.DEC, doc = "datagrams to all subscribers"},
  {name = "control", size = 120, count = 1, layout = "ControlCounters"},
  {name = "serial_sent", size = 8, count = 1, kind = "uint64", title = "Serial sent", base = base.DEC, doc = "frames and messages on the serial line"},
  {name = "serial_dropped", size = 8, count = 1, kind = "uint64", title = "Serial dropped", base = base.DEC, doc = "of these, not sent: the line was busy"},
  {name = "serial_refused", size = 8, count = 1, kind = "uint64", title = "Serial refused", base = base.DEC, doc = "frames and messages from the serial line that were damaged or unknown"},
  {name = "events", size = 4, count = 1, kind = "uint32", title = "Events", base = base.DEC, doc = "sequence of the newest event, which made these conditions active; 1: there was none yet; 0: not told"},
}

layouts.event = {
  message = "event",
  bytes = 28,
  {name = "sequence", size = 4, count = 1, kind = "uint32", title = "Sequence", base = base.DEC, doc = "advances with each change, the first is 2; the repetition has the same"},
  {name = "condition", size = 1, count = 1, kind = "uint8", title = "Condition", base = base.DEC, names = "Condition", doc = "see \"Events\""},
  {name = "severity", size = 1, count = 1, kind = "uint8", title = "Severity", base = base.DEC, names = "Severity", doc = "of it"},
  {name = "reaction", size = 1, count = 1, kind = "uint8", title = "Reaction", base = base.DEC, names = "Reaction", doc = "what the robot should do while it is active"},
  {name = "active", size = 1, count = 1, kind = "uint8", title = "Active", base = base.DEC, doc = "1: it began, 0: it ended"},
  {name = "count", size = 4, count = 1, kind = "uint32", title = "Count", base = base.DEC, doc = "how often it has begun since the sender's start"},
  {name = "value", size = 4, count = 1, kind = "uint32", title = "Value", base = base.DEC, doc = "depends on the condition"},
  {name = "at_ns", size = 8, count = 1, kind = "int64", title = "At ns", base = base.DEC, doc = "when, ns, clock of the header"},
  {name = "former", size = 4, count = 1, kind = "uint32", title = "Former", base = base.DEC, doc = "of calibration changed: the fingerprint of the one before; of release on trial: the fingerprint of the release; of settings changed: 1 the network is on trial until an admin saves it, 2 it is as before, since nobody did, else 0; else 0"},
}

layouts.parity = {
  message = "parity",
  bytes = 18,
  tail = "data",
  {name = "count", size = 2, count = 1, kind = "uint16", title = "Count", base = base.DEC, doc = "packets of the frame, as in the headers of its parts"},
  {name = "type", size = 1, count = 1, kind = "uint8", title = "Type", base = base.DEC, doc = "exclusive or over the group's packets, as all that follow: type"},
  {name = "flags", size = 1, count = 1, kind = "uint8", title = "Flags", base = base.DEC, doc = "flags"},
  {name = "stream", size = 1, count = 1, kind = "uint8", title = "Stream", base = base.DEC, doc = "stream"},
  {name = "codec", size = 1, count = 1, kind = "uint8", title = "Codec", base = base.DEC, doc = "codec"},
  {name = "image_width", size = 2, count = 1, kind = "uint16", title = "Image width", base = base.DEC, doc = "image width"},
  {name = "image_height", size = 2, count = 1, kind = "uint16", title = "Image height", base = base.DEC, doc = "image height"},
  {name = "first_row", size = 2, count = 1, kind = "uint16", title = "First row", base = base.DEC, doc = "first row"},
  {name = "first_column", size = 2, count = 1, kind = "uint16", title = "First column", base = base.DEC, doc = "first column"},
  {name = "pixel_count", size = 2, count = 1, kind = "uint16", title = "Pixel count", base = base.DEC, doc = "pixel count"},
  {name = "payload_length", size = 2, count = 1, kind = "uint16", title = "Payload length", base = base.DEC, doc = "payload length"},
}

layouts.announce = {
  message = "announce",
  bytes = 128,
  {name = "request_id", size = 4, count = 1, kind = "uint32", title = "Request id", base = base.DEC, doc = "of the discover that it answers; 0 in the beacon"},
  {name = "port", size = 2, count = 1, kind = "uint16", title = "Port", base = base.DEC, doc = "UDP port of the sensor for requests"},
  {name = "subscribers", size = 1, count = 1, kind = "uint8", title = "Subscribers", base = base.DEC, doc = "now"},
  {name = "most_subscribers", size = 1, count = 1, kind = "uint8", title = "Most subscribers", base = base.DEC, doc = "that it takes"},
  {name = "serial", size = 16, count = 1, kind = "string", title = "Serial", doc = "serial number, UTF-8, filled up with 0, as all texts"},
  {name = "name", size = 32, count = 1, kind = "string", title = "Name", doc = "given by whoever owns it"},
  {name = "version", size = 16, count = 1, kind = "string", title = "Version", doc = "of its software"},
  {name = "board", size = 16, count = 1, kind = "string", title = "Board", doc = "what it is"},
  {name = "uptime_ms", size = 8, count = 1, kind = "uint64", title = "Uptime ms", base = base.DEC, doc = "since its start, ms"},
  {name = "image_width", size = 2, count = 1, kind = "uint16", title = "Image width", base = base.DEC, doc = "of its depth, pixels"},
  {name = "image_height", size = 2, count = 1, kind = "uint16", title = "Image height", base = base.DEC, doc = "rows"},
  {name = "rate_millihertz", size = 4, count = 1, kind = "uint32", title = "Rate millihertz", base = base.DEC, doc = "frames of the last second, 1/1000 Hz"},
  {name = "state", size = 1, count = 1, kind = "uint8", title = "State", base = base.DEC, names = "SensorState", doc = "whether there are frames"},
  {name = "reserved", size = 23, count = 1, kind = "bytes", title = "Reserved"},
}

layouts.sectors = {
  message = "sectors",
  bytes = 156,
  {name = "first_udeg", size = 4, count = 1, kind = "int32", title = "First udeg", base = base.DEC, doc = "direction of the middle of the first sector, millionths of a degree, clockwise from straight ahead"},
  {name = "step_udeg", size = 4, count = 1, kind = "uint32", title = "Step udeg", base = base.DEC, doc = "from one sector to the next"},
  {name = "least_cm", size = 2, count = 1, kind = "uint16", title = "Least cm", base = base.DEC, doc = "nearest distance that can be told"},
  {name = "most_cm", size = 2, count = 1, kind = "uint16", title = "Most cm", base = base.DEC, doc = "furthest"},
  {name = "distances_cm", size = 2, count = 72, kind = "uint16", title = "Distances cm", base = base.DEC, doc = "horizontal distance from the camera, rounded towards it; 65535: unknown"},
}

layouts.raw_info = {
  message = "raw info",
  bytes = 148,
  {name = "edge_ns", size = 8, count = 1, kind = "int64", title = "Edge ns", base = base.DEC, doc = "trigger edge that it was collected at, ns, same clock as the header"},
  {name = "pair_exposures", size = 16, count = 2, layout = "Window"},
  {name = "pmd_exposures", size = 16, count = 4, layout = "Window"},
  {name = "sequences", size = 4, count = 3, kind = "uint32", title = "Sequences", base = base.DEC, doc = "of the left, the right and the PMD camera, as each counts its exposures"},
  {name = "number", size = 4, count = 1, kind = "uint32", title = "Number", base = base.DEC, doc = "of these pictures, from 1: advances with each exposure whose pictures were begun for this request"},
  {name = "dropped", size = 4, count = 1, kind = "uint32", title = "Dropped", base = base.DEC, doc = "exposures that were due and not sent, or not to their end, for this request: the link or the sensor had no time for them"},
  {name = "width", size = 2, count = 1, kind = "uint16", title = "Width", base = base.DEC, doc = "of each picture of the pair as it is sent, pixels; 0: the part that was asked for lies outside"},
  {name = "height", size = 2, count = 1, kind = "uint16", title = "Height", base = base.DEC, doc = "rows"},
  {name = "column", size = 2, count = 1, kind = "uint16", title = "Column", base = base.DEC, doc = "first column of it, pixels of the camera"},
  {name = "row", size = 2, count = 1, kind = "uint16", title = "Row", base = base.DEC, doc = "first row"},
  {name = "camera_width", size = 2, count = 1, kind = "uint16", title = "Camera width", base = base.DEC, doc = "of the whole picture of each camera of the pair, pixels; 0 without a pair"},
  {name = "camera_height", size = 2, count = 1, kind = "uint16", title = "Camera height", base = base.DEC, doc = "rows"},
  {name = "pmd_width", size = 2, count = 1, kind = "uint16", title = "Pmd width", base = base.DEC, doc = "of each sample, pixels; 0 without samples"},
  {name = "pmd_height", size = 2, count = 1, kind = "uint16", title = "Pmd height", base = base.DEC, doc = "rows"},
  {name = "pictures", size = 1, count = 1, kind = "uint8", title = "Pictures", base = base.DEC, doc = "that follow, the sum as in the request"},
  {name = "step", size = 1, count = 1, kind = "uint8", title = "Step", base = base.DEC, doc = "from one column or row of the pair to the next, pixels of the camera"},
  {name = "state", size = 1, count = 1, kind = "uint8", title = "State", base = base.DEC, doc = "of what the frame was computed with, since the exposure sent before, the sum of: 1 all that counts from frame to frame was begun anew; 2 depth was averaged with no frame before"},
  {name = "pmd_every", size = 1, count = 1, kind = "uint8", title = "Pmd every", base = base.DEC, doc = "the PMD camera exposes at every so many-th edge"},
  {name = "disparities", size = 2, count = 1, kind = "uint16", title = "Disparities", base = base.DEC, doc = "candidates of the search, which settings may leave to the rig"},
  {name = "reserved", size = 2, count = 1, kind = "bytes", title = "Reserved"},
}

layouts.subscribe = {
  message = "subscribe",
  bytes = 32,
  {name = "request_id", size = 4, count = 1, kind = "uint32", title = "Request id", base = base.DEC, doc = "any number, comes back in the answer"},
  {name = "lease_ms", size = 2, count = 1, kind = "uint16", title = "Lease ms", base = base.DEC, doc = "how long to send without hearing from us; the sensor takes 500 to 10,000, 0: 3,000"},
  {name = "reserved", size = 2, count = 1, kind = "bytes", title = "Reserved"},
  {name = "cookie", size = 8, count = 1, kind = "uint64", title = "Cookie", base = base.HEX, doc = "of an answer; 0: none yet"},
  {name = "stream_key", size = 4, count = 1, kind = "uint32", title = "Stream key", base = base.DEC, doc = "of a signed subscribe: number of the stream key that we have, 0: none; see \"Signed streams\""},
  {name = "raw", size = 12, count = 1, layout = "RawRequest"},
}

layouts.subscribed = {
  message = "subscribed",
  bytes = 16,
  {name = "request_id", size = 4, count = 1, kind = "uint32", title = "Request id", base = base.DEC, doc = "of the request"},
  {name = "result", size = 1, count = 1, kind = "uint8", title = "Result", base = base.DEC, names = "SubscribeResult", doc = "see below"},
  {name = "subscribers", size = 1, count = 1, kind = "uint8", title = "Subscribers", base = base.DEC, doc = "now"},
  {name = "lease_ms", size = 2, count = 1, kind = "uint16", title = "Lease ms", base = base.DEC, doc = "granted; ask again before it is over, best after a third of it"},
  {name = "cookie", size = 8, count = 1, kind = "uint64", title = "Cookie", base = base.HEX, doc = "for the next request"},
}

layouts.settings_request = {
  message = "settings request",
  bytes = 24,
  tail = "text",
  {name = "request_id", size = 4, count = 1, kind = "uint32", title = "Request id", base = base.DEC, doc = "any number, comes back in the answer"},
  {name = "operation", size = 1, count = 1, kind = "uint8", title = "Operation", base = base.DEC, names = "SettingsOperation", doc = "see \"Settings\""},
  {name = "document", size = 1, count = 1, kind = "uint8", title = "Document", base = base.DEC, names = "SettingsDocument", doc = "of get"},
  {name = "offset", size = 2, count = 1, kind = "uint16", title = "Offset", base = base.DEC, doc = "of get and keys: where the answer's text begins in the document, bytes"},
  {name = "cookie", size = 8, count = 1, kind = "uint64", title = "Cookie", base = base.HEX, doc = "of an answer; 0: none yet. Not looked at on serial lines"},
  {name = "padding", size = 8, count = 1, kind = "bytes", title = "Padding"},
}

layouts.settings_answer = {
  message = "settings answer",
  bytes = 24,
  tail = "text",
  {name = "request_id", size = 4, count = 1, kind = "uint32", title = "Request id", base = base.DEC, doc = "of the request"},
  {name = "result", size = 1, count = 1, kind = "uint8", title = "Result", base = base.DEC, names = "SettingsResult", doc = "see \"Settings\""},
  {name = "restart", size = 1, count = 1, kind = "uint8", title = "Restart", base = base.DEC, doc = "1: some of the active settings wait for the next start"},
  {name = "total", size = 2, count = 1, kind = "uint16", title = "Total", base = base.DEC, doc = "of get and keys: length of the document, bytes"},
  {name = "revision", size = 4, count = 1, kind = "uint32", title = "Revision", base = base.DEC, doc = "of the active settings: advances with every change"},
  {name = "reserved", size = 4, count = 1, kind = "bytes", title = "Reserved"},
  {name = "cookie", size = 8, count = 1, kind = "uint64", title = "Cookie", base = base.HEX, doc = "for the next request"},
}

layouts.signed_fields = {
  message = "signed fields",
  bytes = 24,
  tail = "data",
  {name = "key_id", size = 4, count = 1, kind = "uint32", title = "Key id", base = base.DEC, doc = "of the key; in the answer the same"},
  {name = "type", size = 1, count = 1, kind = "uint8", title = "Type", base = base.DEC, doc = "type of the message that is signed: 128, 130 or 132, in the answer 129 or 133"},
  {name = "reserved", size = 3, count = 1, kind = "bytes", title = "Reserved"},
  {name = "counter", size = 8, count = 1, kind = "uint64", title = "Counter", base = base.DEC, doc = "above all that this key has signed in this session; in the answer the same"},
  {name = "highest", size = 8, count = 1, kind = "uint64", title = "Highest", base = base.DEC, doc = "of the answer: the highest counter of this key so far; in requests 0"},
}

layouts.upload_request = {
  message = "upload request",
  bytes = 48,
  tail = "data",
  {name = "step", size = 1, count = 1, kind = "uint8", title = "Step", base = base.DEC, names = "UploadStep", doc = "see \"Uploads\""},
  {name = "kind", size = 1, count = 1, kind = "uint8", title = "Kind", base = base.DEC, names = "UploadKind", doc = "of what is uploaded"},
  {name = "reserved", size = 2, count = 1, kind = "bytes", title = "Reserved"},
  {name = "total", size = 4, count = 1, kind = "uint32", title = "Total", base = base.DEC, doc = "bytes of it all"},
  {name = "offset", size = 4, count = 1, kind = "uint32", title = "Offset", base = base.DEC, doc = "of chunk: where its bytes begin"},
  {name = "reserved2", size = 4, count = 1, kind = "bytes", title = "Reserved2"},
  {name = "hash", size = 1, count = 32, kind = "uint8", title = "Hash", base = base.DEC, doc = "of it all: BLAKE2b of 32 bytes"},
}

layouts.upload_answer = {
  message = "upload answer",
  bytes = 16,
  {name = "wanted", size = 4, count = 1, kind = "uint32", title = "Wanted", base = base.DEC, doc = "offset of the next chunk: all before it is there; the total: commit"},
  {name = "chunk", size = 2, count = 1, kind = "uint16", title = "Chunk", base = base.DEC, doc = "bytes of a chunk, at most"},
  {name = "state", size = 2, count = 1, kind = "uint16", title = "State", base = base.DEC, names = "UploadState", doc = "of what is in force"},
  {name = "fingerprint", size = 4, count = 1, kind = "uint32", title = "Fingerprint", base = base.DEC, doc = "of the calibration that is in force; of updates the CRC-32C of the release's head that runs, 0: none"},
  {name = "former", size = 4, count = 1, kind = "uint32", title = "Former", base = base.DEC, doc = "of commit and revert: of the calibration that was in force before; of updates of the whole release in the other slot, 0: none"},
}

layouts.download_request = {
  message = "download request",
  bytes = 8,
  {name = "kind", size = 1, count = 1, kind = "uint8", title = "Kind", base = base.DEC, names = "UploadKind", doc = "of what is read: those of uploads"},
  {name = "reserved", size = 3, count = 1, kind = "bytes", title = "Reserved"},
  {name = "offset", size = 4, count = 1, kind = "uint32", title = "Offset", base = base.DEC, doc = "where the bytes of the answer begin"},
}

layouts.download_answer = {
  message = "download answer",
  bytes = 16,
  tail = "data",
  {name = "total", size = 4, count = 1, kind = "uint32", title = "Total", base = base.DEC, doc = "bytes of it all"},
  {name = "offset", size = 4, count = 1, kind = "uint32", title = "Offset", base = base.DEC, doc = "as it was asked for"},
  {name = "fingerprint", size = 4, count = 1, kind = "uint32", title = "Fingerprint", base = base.DEC, doc = "of the calibration that is in force; of other kinds 0"},
  {name = "reserved", size = 4, count = 1, kind = "bytes", title = "Reserved"},
}

layouts.stream_key = {
  message = "stream key",
  bytes = 40,
  {name = "number", size = 4, count = 1, kind = "uint32", title = "Number", base = base.DEC, doc = "of the stream key, as in the datagrams that it signs; 0: none is handed over"},
  {name = "tags", size = 1, count = 1, kind = "uint8", title = "Tags", base = base.DEC, doc = "how tags are made: 1, with keys of blocks of 16, as below; a receiver takes no stream key with another value"},
  {name = "reserved", size = 3, count = 1, kind = "bytes", title = "Reserved"},
  {name = "sealed", size = 1, count = 32, kind = "uint8", title = "Sealed", base = base.DEC, doc = "the stream key, exclusive or the pad of this answer"},
}

layouts.stream_signature = {
  message = "stream signature",
  bytes = 28,
  {name = "number", size = 4, count = 1, kind = "uint32", title = "Number", base = base.DEC, doc = "of the stream key; 0: not signed"},
  {name = "counter", size = 8, count = 1, kind = "uint64", title = "Counter", base = base.DEC, doc = "of the datagrams that this key signs: rises by one with each, from 1"},
  {name = "tag", size = 1, count = 16, kind = "uint8", title = "Tag", base = base.DEC, doc = "of all else in the datagram but the CRC"},
}

layouts.pair_request = {
  message = "pair request",
  bytes = 112,
  {name = "request_id", size = 4, count = 1, kind = "uint32", title = "Request id", base = base.DEC, doc = "any number, comes back in the answer"},
  {name = "step", size = 1, count = 1, kind = "uint8", title = "Step", base = base.DEC, names = "PairStep", doc = "see below"},
  {name = "method", size = 1, count = 1, kind = "uint8", title = "Method", base = base.DEC, names = "PairMethod", doc = "see below; the same in all steps. Role, key id and name count at begin"},
  {name = "role", size = 1, count = 1, kind = "uint8", title = "Role", base = base.DEC, names = "Role", doc = "that the key shall have; a key that is renewed keeps its own, and its name, whatever is named"},
  {name = "reserved", size = 1, count = 1, kind = "bytes", title = "Reserved"},
  {name = "cookie", size = 8, count = 1, kind = "uint64", title = "Cookie", base = base.HEX, doc = "of an answer; 0: none yet. Not looked at on serial lines"},
  {name = "attempt", size = 8, count = 1, kind = "uint64", title = "Attempt", base = base.DEC, doc = "of the answer to begin; there 0"},
  {name = "key_id", size = 4, count = 1, kind = "uint32", title = "Key id", base = base.DEC, doc = "of method key; else 0"},
  {name = "reserved2", size = 4, count = 1, kind = "bytes", title = "Reserved2"},
  {name = "name", size = 32, count = 1, kind = "string", title = "Name", doc = "whose key it is"},
  {name = "value", size = 1, count = 32, kind = "uint8", title = "Value", base = base.DEC, doc = "depends on the step"},
  {name = "nonce", size = 1, count = 16, kind = "uint8", title = "Nonce", base = base.DEC, doc = "of reveal: the client's; of open: of this opening; of begin with method code or key: the proof that the client knows it, see below, or 0"},
}

layouts.pair_answer = {
  message = "pair answer",
  bytes = 80,
  {name = "request_id", size = 4, count = 1, kind = "uint32", title = "Request id", base = base.DEC, doc = "of the request"},
  {name = "result", size = 1, count = 1, kind = "uint8", title = "Result", base = base.DEC, names = "PairResult", doc = "see below"},
  {name = "reserved", size = 3, count = 1, kind = "bytes", title = "Reserved"},
  {name = "cookie", size = 8, count = 1, kind = "uint64", title = "Cookie", base = base.HEX, doc = "for the next request"},
  {name = "attempt", size = 8, count = 1, kind = "uint64", title = "Attempt", base = base.DEC, doc = "random, for the steps that follow"},
  {name = "key_id", size = 4, count = 1, kind = "uint32", title = "Key id", base = base.DEC, doc = "of the key that comes of it"},
  {name = "reserved2", size = 4, count = 1, kind = "bytes", title = "Reserved2"},
  {name = "value", size = 1, count = 32, kind = "uint8", title = "Value", base = base.DEC, doc = "of begin: the sensor's public key; of reveal and confirm: begins with a tag of the sensor; of open and accept with `waiting`: what is asked for, see below"},
  {name = "nonce", size = 1, count = 16, kind = "uint8", title = "Nonce", base = base.DEC, doc = "of begin: the sensor's"},
}

layouts.discover = {
  message = "discover",
  bytes = 128,
  {name = "request_id", size = 4, count = 1, kind = "uint32", title = "Request id", base = base.DEC, doc = "any number but 0, comes back in the answer"},
  {name = "padding", size = 124, count = 1, kind = "bytes", title = "Padding"},
}

local payload_of = {
  [2] = "frame_info",
  [64] = "calibration",
  [65] = "health",
  [67] = "event",
  [66] = "parity",
  [68] = "announce",
  [69] = "sectors",
  [70] = "raw_info",
  [128] = "subscribe",
  [130] = "subscribe",
  [129] = "subscribed",
  [132] = "settings_request",
  [133] = "settings_answer",
  [136] = "signed_fields",
  [137] = "signed_fields",
  [138] = "pair_request",
  [139] = "pair_answer",
  [134] = "discover",
}
-- made: end

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
