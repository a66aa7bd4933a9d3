#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/packetizer.h"
#include "tests/firmware/wire/wire_support.h"

namespace stof::wire {
namespace {

using test::Datagram;

std::vector<std::string> document() {
  std::ifstream file(STOF_WIRE_DOCUMENT);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    lines.push_back(line);
  }
  return lines;
}

void append_hex(const std::string& text, Datagram& bytes) {
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    unsigned value = 256;
    std::from_chars(word.data(), word.data() + word.size(), value, 16);
    ASSERT_LT(value, 256U) << word;
    bytes.push_back(static_cast<std::byte>(value));
  }
}

// The block between ```hex and ```.
Datagram dump_of(const std::vector<std::string>& lines) {
  Datagram bytes;
  auto line = std::ranges::find(lines, "```hex");
  for (line = line == lines.end() ? line : line + 1; line != lines.end() && *line != "```";
       ++line) {
    append_hex(*line, bytes);
  }
  return bytes;
}

// The packet that the document describes, made anew.
Datagram worked_packet() {
  std::vector<dsp::QuarterMm> depth{4000, 4001, 4002, 0, 8000, 8010, 65535, 1};
  std::vector<dsp::QuarterMm> width(8);
  std::vector<dsp::Source> source(8);
  test::KeepingSink sink;
  Packetizer packetizer({.device_id = 0x0A0B0C0D, .session_id = 0x11223344}, sink);
  const FrameStamp stamp{.number = 7,
                         .freshness = 6,
                         .exposure_middle_ns = 1'234'567'890'123,
                         .health = Health::kDegraded,
                         .clock = ClockState::kEmulated};
  const Sent sent = packetizer.publish(
      stamp, {}, {{depth.data(), 4, 2}, {width.data(), 4, 2}, {source.data(), 4, 2}});
  EXPECT_EQ(sent.packets, 4U);
  return sink.sent.at(1);
}

TEST(WireDocument, WorkedPacketIsWhatTheSenderSends) {
  const Datagram dump = dump_of(document());
  ASSERT_EQ(dump.size(), 72U) << STOF_WIRE_DOCUMENT;
  EXPECT_EQ(dump, worked_packet());
}

TEST(WireDocument, WorkedPacketIsAccepted) {
  const Datagram dump = dump_of(document());
  const auto packet = parse_packet(dump);
  ASSERT_TRUE(packet) << to_string(packet.error());
  EXPECT_TRUE(consistent_tile(*packet));
}

// Rows such as "| 20 | `07 00 00 00` | frame number 7 |": together they are the packet, in order.
TEST(WireDocument, ByteByByteTableCoversTheWorkedPacket) {
  const std::vector<std::string> lines = document();
  Datagram table;
  auto line = std::ranges::find(lines, "## A worked packet");
  ASSERT_NE(line, lines.end());
  for (++line; line != lines.end() && !line->starts_with("## "); ++line) {
    const std::size_t open = line->find('`');
    if (!line->starts_with("| ") || open == std::string::npos) {
      continue;
    }
    EXPECT_EQ(std::stoul(line->substr(2)), table.size()) << *line;
    append_hex(line->substr(open + 1, line->find('`', open + 1) - open - 1), table);
  }
  EXPECT_EQ(table, dump_of(lines));
}

}  // namespace
}  // namespace stof::wire
