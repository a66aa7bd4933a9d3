#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "firmware/wire/codec/rvl_decode.h"
#include "firmware/wire/codec/rvl_encode.h"
#include "firmware/wire/messages/subscribe.h"
#include "firmware/wire/packet.h"

namespace stof::wire {
namespace {

using Datagram = std::vector<std::byte>;

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

// The first block between ```hex and ``` below the heading.
Datagram dump_below(const std::vector<std::string>& lines, std::string_view heading) {
  Datagram bytes;
  auto line = std::find(std::ranges::find(lines, heading), lines.end(), "```hex");
  for (line = line == lines.end() ? line : line + 1; line != lines.end() && *line != "```";
       ++line) {
    append_hex(*line, bytes);
  }
  return bytes;
}

constexpr std::string_view kRaw = "## A worked packet";
constexpr std::string_view kRvl = "## The same packet in RVL";
constexpr std::array<std::uint16_t, 8> kPixels{4000, 4001, 4002, 0, 8000, 8010, 65535, 1};

// The packet that the document describes, made anew.
Datagram worked_packet(Codec codec) {
  const Header header{.type = PacketType::kTile,
                      .origin = {.device_id = 0x0A0B0C0D, .session_id = 0x11223344},
                      .frame = {.number = 7,
                                .freshness = 6,
                                .exposure_middle_ns = 1'234'567'890'123,
                                .health = Health::kDegraded,
                                .clock = ClockState::kEmulated},
                      .stream = Stream::kDepth,
                      .codec = codec,
                      .index = 1,
                      .count = 4,
                      .image_width = 4,
                      .image_height = 2,
                      .pixel_count = 8};
  DatagramBuffer buffer{};
  const std::span<std::byte, kMaxPayload> payload = payload_space(buffer);
  std::size_t bytes = 2 * kPixels.size();
  if (codec == Codec::kRaw16) {
    put_pixels<std::uint16_t>(payload.first(bytes), kPixels);
  } else {
    const RvlCoded coded = rvl_encode<std::uint16_t>(kPixels, payload);
    EXPECT_EQ(coded.values, kPixels.size());
    bytes = coded.bytes;
  }
  const std::span<const std::byte> packet = seal_packet(header, bytes, buffer);
  return {packet.begin(), packet.end()};
}

TEST(WorkedPackets, WorkedPacketIsWhatTheSenderSends) {
  const Datagram dump = dump_below(document(), kRaw);
  ASSERT_EQ(dump.size(), 72U) << STOF_WIRE_DOCUMENT;
  EXPECT_EQ(dump, worked_packet(Codec::kRaw16));
}

TEST(WorkedPackets, WorkedPacketOfRvlIsWhatTheSenderSends) {
  const Datagram dump = dump_below(document(), kRvl);
  ASSERT_EQ(dump.size(), 68U) << STOF_WIRE_DOCUMENT;
  EXPECT_EQ(dump, worked_packet(Codec::kRvl16));
}

TEST(WorkedPackets, WorkedPacketsAreAccepted) {
  for (const std::string_view heading : {kRaw, kRvl}) {
    const Datagram dump = dump_below(document(), heading);
    const auto packet = parse_packet(dump);
    ASSERT_TRUE(packet) << static_cast<int>(packet.error());
    EXPECT_TRUE(consistent_tile(*packet)) << heading;
  }
}

TEST(WorkedPackets, WorkedPacketOfRvlHasThePixels) {
  const Datagram dump = dump_below(document(), kRvl);
  const auto packet = parse_packet(dump);
  ASSERT_TRUE(packet);
  std::array<std::uint16_t, 8> pixels{};
  ASSERT_EQ(rvl_decode<std::uint16_t>(packet->payload, pixels), Status::kOk);
  EXPECT_EQ(pixels, kPixels);
}

TEST(WorkedPackets, WorkedRequestIsOneForTheSensor) {
  const Datagram dump = dump_below(document(), "### Subscription");
  ASSERT_EQ(dump.size(), 88U);
  const auto packet = parse_packet(dump);
  ASSERT_TRUE(packet) << static_cast<int>(packet.error());
  EXPECT_EQ(packet->header.type, PacketType::kSubscribe);
  EXPECT_EQ(packet->header.origin.device_id, 0U);
  const Result<Subscribe> request = decode_subscribe(packet->payload);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->request_id, 1U);
  EXPECT_EQ(request->lease_ms, 3000);
  EXPECT_EQ(request->cookie, 0U);
}

// Rows such as "| 20 | `07 00 00 00` | frame number 7 |": together they are the packet, in order.
TEST(WorkedPackets, ByteByByteTableCoversTheWorkedPacket) {
  const std::vector<std::string> lines = document();
  Datagram table;
  auto line = std::ranges::find(lines, kRaw);
  ASSERT_NE(line, lines.end());
  for (++line; line != lines.end() && !line->starts_with("## "); ++line) {
    const std::size_t open = line->find('`');
    if (!line->starts_with("| ") || open == std::string::npos) {
      continue;
    }
    EXPECT_EQ(std::stoul(line->substr(2)), table.size()) << *line;
    append_hex(line->substr(open + 1, line->find('`', open + 1) - open - 1), table);
  }
  EXPECT_EQ(table, dump_below(lines, kRaw));
}

}  // namespace
}  // namespace stof::wire
