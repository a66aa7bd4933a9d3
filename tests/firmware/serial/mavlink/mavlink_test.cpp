#include "firmware/serial/mavlink/mavlink.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <span>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/serial/mavlink/mavlink_reader.h"
#include "firmware/wire/bytes.h"
#include "tests/support/random.h"

namespace stof::firmware::test {
namespace {

using stof::test::Random;
using namespace mavlink;
using Bytes = std::vector<std::byte>;

Bytes copy(std::span<const std::byte> bytes) { return {bytes.begin(), bytes.end()}; }

Bytes heartbeat(Writer& writer) {
  Buffer buffer{};
  return copy(writer.write(Heartbeat{}, buffer));
}

// A frame of either version, sealed by the formula.
Bytes frame(int version, const MessageKind& kind, const Bytes& payload,
            bool has_signature = false) {
  Bytes out;
  const auto put = [&](unsigned value) { out.push_back(static_cast<std::byte>(value)); };
  put(version == 1 ? 0xFEU : 0xFDU);
  put(static_cast<unsigned>(payload.size()));
  if (version == 2) {
    put(has_signature ? 1U : 0U);
    put(0);
  }
  for (const unsigned value : {9U, 1U, 1U}) {  // sequence, system, component
    put(value);
  }
  put(kind.id & 255U);
  if (version == 2) {
    put((kind.id >> 8) & 255U);
    put(kind.id >> 16);
  }
  out.insert(out.end(), payload.begin(), payload.end());
  const std::array extra{std::byte{kind.crc_extra}};
  const unsigned crc = crc16(extra, crc16(std::span(out).subspan(1)));
  put(crc & 255U);
  put(crc >> 8);
  out.insert(out.end(), has_signature ? 13 : 0, std::byte{0xFD});
  return out;
}

struct Found {
  std::vector<std::uint8_t> sequences;
  std::vector<std::uint8_t> versions;
};

Found read_all(Reader& reader, std::span<const std::byte> bytes) {
  Found found;
  while (const std::optional<Message> message = reader.take(bytes)) {
    found.sequences.push_back(message->sequence);
    found.versions.push_back(message->version);
  }
  EXPECT_TRUE(bytes.empty());
  return found;
}

TEST(MavlinkCrc, GivesTheKnownValue) {
  constexpr std::string_view kCheck = "123456789";
  EXPECT_EQ(crc16(std::as_bytes(std::span(kCheck))), 0x6F91);
}

TEST(MavlinkWriter, WritesAHeartbeatByteByByte) {
  Writer writer(7, 196);
  Buffer buffer{};
  const Bytes first = copy(writer.write(Heartbeat{.state = State::kCritical}, buffer));
  const std::array<int, 19> expected{0xFD, 9, 0, 0, 0, 7, 196, 0, 0, 0, 0, 0, 0, 0, 18, 8, 0, 5, 3};
  ASSERT_EQ(first.size(), expected.size() + 2);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(std::to_integer<int>(first[i]), expected[i]) << i;
  }
  EXPECT_EQ(std::to_integer<int>(heartbeat(writer)[4]), 1);  // the next in sequence
}

TEST(MavlinkWriter, LeavesOutZerosAtTheEndOfAPayload) {
  Writer writer(1, 1);
  Buffer buffer{};
  // Quality is the last byte of DISTANCE_SENSOR; the field of view before it, the first extension.
  EXPECT_EQ(writer.write(DistanceSensor{.quality = 1}, buffer).size(), 12U + 39);
  const float quarter = std::bit_cast<float>(std::uint32_t{0x3E800000});
  EXPECT_EQ(writer.write(DistanceSensor{.vertical_fov_rad = quarter}, buffer).size(), 12U + 22);
  EXPECT_EQ(writer.write(DistanceSensor{}, buffer).size(), 12U + 14);
  EXPECT_EQ(writer.write(ObstacleDistance{}, buffer).size(), 12U + 167);
}

TEST(MavlinkReader, ReadsBothVersionsSignedAndUnsigned) {
  Reader reader;
  Bytes line;
  for (const Bytes& more :
       {frame(1, kHeartbeatKind, Bytes(9, std::byte{3})), frame(2, kHeartbeatKind, Bytes(9)),
        frame(2, kPingKind, Bytes(14, std::byte{0xFE})), frame(2, kPingKind, Bytes(3), true),
        frame(1, kPingKind, Bytes(14))}) {
    line.insert(line.end(), more.begin(), more.end());
  }
  EXPECT_EQ(read_all(reader, line).versions, (std::vector<std::uint8_t>{1, 2, 2, 2, 1}));
  EXPECT_EQ(reader.counters().damaged, 0U);
}

TEST(MavlinkReader, TakesBytesOneByOneAndFillsUpWhatWasLeftOut) {
  const Bytes ping = frame(2, kPingKind, {std::byte{42}});
  Reader reader;
  int messages = 0;
  for (const std::byte& value : ping) {
    std::span<const std::byte> one(&value, 1);
    while (const std::optional<Message> message = reader.take(one)) {
      ++messages;
      ASSERT_EQ(message->payload.size(), 14U);
      EXPECT_EQ(message->payload[0], std::byte{42});
      EXPECT_TRUE(std::ranges::all_of(message->payload.subspan(1),
                                      [](std::byte b) { return b == std::byte{0}; }));
    }
  }
  EXPECT_EQ(messages, 1);
}

TEST(MavlinkReader, PassesOverMessagesItDoesNotKnow) {
  Writer writer(1, 1);
  Buffer buffer{};
  Bytes line = copy(writer.write(ObstacleDistance{}, buffer));
  const Bytes behind = heartbeat(writer);
  line.insert(line.end(), behind.begin(), behind.end());
  Reader reader;
  EXPECT_EQ(read_all(reader, line).sequences, std::vector<std::uint8_t>{1});
  EXPECT_EQ(reader.counters().damaged, 0U);
  EXPECT_EQ(reader.counters().skipped, 12U + 167);
}

TEST(MavlinkReader, NeverBelievesADamagedMessage) {
  Writer writer(1, 1);
  const Bytes good = heartbeat(writer);
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes bad = good;
      bad[i] ^= static_cast<std::byte>(1 << bit);
      Reader reader;
      // Behind it one that is whole: it is found wherever the damage is.
      bad.insert(bad.end(), good.begin(), good.end());
      ASSERT_EQ(read_all(reader, bad).sequences.size(), 1U) << i << " " << bit;
    }
  }
}

TEST(MavlinkReader, FindsTheMessageBehindACutOne) {
  Random random(5);
  Writer writer(1, 1);
  Reader reader;
  for (int i = 0; i < 10'000; ++i) {
    Bytes cut = heartbeat(writer);
    const int from = random.between(0, static_cast<int>(cut.size()) - 1);
    const int to = random.between(from + 1, static_cast<int>(cut.size()));
    if (from + 1 == static_cast<int>(cut.size()) && cut.back() == std::byte{0xFD}) {
      continue;  // the next one's first byte makes it whole again
    }
    cut.erase(cut.begin() + from, cut.begin() + to);
    const Bytes next = heartbeat(writer);
    cut.insert(cut.end(), next.begin(), next.end());
    ASSERT_EQ(read_all(reader, cut).sequences, std::vector{std::to_integer<std::uint8_t>(next[4])})
        << i;
  }
}

TEST(MavlinkReader, FindsNoMessageInNoise) {
  const bool thorough = std::getenv("STOF_LONG") != nullptr;
  const int rounds = thorough ? 25'000 : 250;
  Random random(6);
  Reader reader;
  Bytes noise(4000);
  for (int i = 0; i < rounds; ++i) {
    random.fill(std::span(noise), 0, 255);
    read_all(reader, noise);
  }
  EXPECT_EQ(reader.counters().messages, 0U);
  EXPECT_GT(reader.counters().skipped, 0U);
}

TEST(MavlinkReader, RemembersAnAutopilotAndNobodyElse) {
  Autopilot autopilot;
  Reader reader;
  Bytes payload(9);
  payload[5] = std::byte{8};  // no autopilot
  const hal::Time now{std::chrono::seconds(5)};
  const Bytes stranger = frame(2, kHeartbeatKind, payload);
  payload[5] = std::byte{3};
  const Bytes pilot = frame(1, kHeartbeatKind, payload);
  std::span<const std::byte> bytes = stranger;
  note_message(*reader.take(bytes), now, autopilot);
  EXPECT_EQ(autopilot.system, 0);
  bytes = pilot;
  note_message(*reader.take(bytes), now, autopilot);
  EXPECT_EQ(autopilot.system, 1);
  EXPECT_EQ(autopilot.last_heard, now);
}

}  // namespace
}  // namespace stof::firmware::test
