#include "hal/framing/cobs.h"

#include <algorithm>
#include <cstdlib>
#include <initializer_list>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/wire/packet.h"
#include "tests/support/random.h"

namespace stof::test {
namespace {

using hal::cobs_bound;
using hal::cobs_encode;
using hal::CobsReader;
using Bytes = std::vector<std::byte>;
using Frames = std::vector<Bytes>;

Bytes bytes_of(std::initializer_list<int> values) {
  Bytes bytes;
  for (const int value : values) {
    bytes.push_back(static_cast<std::byte>(value));
  }
  return bytes;
}

Bytes code_of(const Bytes& frame) {
  Bytes code(cobs_bound(frame.size()));
  code.resize(cobs_encode(frame, code));
  return code;
}

// With the zero behind it.
Bytes on_line(const Bytes& frame) {
  Bytes code = code_of(frame);
  code.push_back(std::byte{0});
  return code;
}

Frames read_all(CobsReader& reader, std::span<const std::byte> bytes) {
  Frames frames;
  while (const auto frame = reader.take(bytes)) {
    frames.emplace_back(frame->begin(), frame->end());
  }
  EXPECT_TRUE(bytes.empty());
  return frames;
}

// Small ones have many zeros, large ones few.
Bytes random_frame(Random& random, std::size_t size, int most) {
  Bytes frame(size);
  for (std::byte& value : frame) {
    value = static_cast<std::byte>(random.between(0, most));
  }
  return frame;
}

Bytes run(int first, std::size_t count) {
  Bytes bytes(count);
  for (std::size_t i = 0; i < count; ++i) {
    bytes[i] = static_cast<std::byte>((static_cast<std::size_t>(first) + i - 1) % 255 + 1);
  }
  return bytes;
}

TEST(Cobs, GivesTheKnownCodes) {
  EXPECT_EQ(code_of({}), bytes_of({1}));
  EXPECT_EQ(code_of(bytes_of({0})), bytes_of({1, 1}));
  EXPECT_EQ(code_of(bytes_of({0, 0})), bytes_of({1, 1, 1}));
  EXPECT_EQ(code_of(bytes_of({0x11, 0x22, 0, 0x33})), bytes_of({3, 0x11, 0x22, 2, 0x33}));
  EXPECT_EQ(code_of(bytes_of({0x11, 0, 0, 0})), bytes_of({2, 0x11, 1, 1, 1}));
  // 254 bytes without a zero are one block; the 255th begins another one.
  Bytes block = run(1, 254);
  block.insert(block.begin(), std::byte{255});
  EXPECT_EQ(code_of(run(1, 254)), block);
  Bytes longer = block;
  longer.push_back(std::byte{2});
  longer.push_back(std::byte{255});
  EXPECT_EQ(code_of(run(1, 255)), longer);
}

TEST(Cobs, BringsBackEveryFrameWithoutAZeroOnTheLine) {
  Random random(1);
  for (std::size_t size = 0; size <= CobsReader::kMaxFrame; ++size) {
    for (const int most : {1, 255}) {
      const Bytes frame = random_frame(random, size, most);
      const Bytes code = code_of(frame);
      ASSERT_LE(code.size(), cobs_bound(size));
      ASSERT_EQ(std::ranges::count(code, std::byte{0}), 0);
      CobsReader reader;
      ASSERT_EQ(read_all(reader, on_line(frame)), (Frames{frame})) << size;
    }
    const Bytes frame = run(static_cast<int>(size), size);
    CobsReader reader;
    ASSERT_EQ(read_all(reader, on_line(frame)), (Frames{frame})) << size;
  }
}

TEST(CobsReader, TakesBytesInPartsOfAnySize) {
  Random random(2);
  Frames frames;
  Bytes line;
  for (int i = 0; i < 100; ++i) {
    frames.push_back(random_frame(random, static_cast<std::size_t>(random.between(1, 600)), 255));
    const Bytes more = on_line(frames.back());
    line.insert(line.end(), more.begin(), more.end());
  }
  for (const std::size_t part : {1U, 2U, 7U, 254U, 4096U}) {
    CobsReader reader;
    Frames found;
    for (std::size_t at = 0; at < line.size(); at += part) {
      for (Bytes& frame :
           read_all(reader, std::span(line).subspan(at, std::min(part, line.size() - at)))) {
        found.push_back(std::move(frame));
      }
    }
    EXPECT_EQ(found, frames) << part;
    EXPECT_EQ(reader.counters().frames, 100U);
  }
}

TEST(CobsReader, CountsWhatItDoesNotHandOut) {
  CobsReader reader;
  EXPECT_TRUE(read_all(reader, bytes_of({0, 0, 0})).empty());
  EXPECT_EQ(reader.counters().empty, 3U);
  EXPECT_TRUE(read_all(reader, bytes_of({5, 1, 2, 0})).empty());  // four bytes were announced
  EXPECT_EQ(reader.counters().broken, 1U);
  EXPECT_TRUE(read_all(reader, on_line(run(1, CobsReader::kMaxFrame + 1))).empty());
  EXPECT_TRUE(read_all(reader, on_line(Bytes(5000, std::byte{0}))).empty());
  EXPECT_EQ(reader.counters().too_long, 2U);
  EXPECT_EQ(read_all(reader, on_line(bytes_of({7}))), (Frames{bytes_of({7})}));
  EXPECT_EQ(reader.counters().frames, 1U);
}

Bytes packet_of(Random& random) {
  wire::DatagramBuffer buffer{};
  const std::size_t payload = static_cast<std::size_t>(random.between(0, wire::kMaxPayload));
  random.fill(wire::payload_space(buffer).first(payload), 0, 255);
  const auto packet = wire::seal_packet({.type = wire::PacketType::kTile}, payload, buffer);
  return {packet.begin(), packet.end()};
}

// What a receiver believes: frames that are packets.
Frames believed(CobsReader& reader, const Bytes& line) {
  Frames packets;
  for (Bytes& frame : read_all(reader, line)) {
    if (wire::parse_packet(frame)) {
      packets.push_back(std::move(frame));
    }
  }
  return packets;
}

TEST(CobsReader, FindsThePacketBehindACutOne) {
  Random random(3);
  CobsReader reader;
  for (int i = 0; i < 10'000; ++i) {
    Bytes cut = on_line(packet_of(random));
    const int from = random.between(0, static_cast<int>(cut.size()) - 1);
    const int to = random.between(from + 1, static_cast<int>(cut.size()));
    const bool ended = to < static_cast<int>(cut.size());
    cut.erase(cut.begin() + from, cut.begin() + to);
    const Bytes next = packet_of(random);
    const Bytes last = packet_of(random);
    for (const Bytes& more : {on_line(next), on_line(last)}) {
      cut.insert(cut.end(), more.begin(), more.end());
    }
    const Frames found = believed(reader, cut);
    // Without its zero the cut one takes the next one along, never a second one; unless nothing at
    // all is left of it.
    const bool next_survives = ended || from == 0;
    ASSERT_EQ(found, next_survives ? (Frames{next, last}) : Frames{last}) << i;
  }
}

TEST(CobsReader, FindsNoPacketInNoise) {
  const bool thorough = std::getenv("STOF_LONG") != nullptr;
  const int rounds = thorough ? 25'000 : 250;
  Random random(4);
  CobsReader reader;
  Bytes noise(4000);
  std::size_t packets = 0;
  for (int i = 0; i < rounds; ++i) {
    random.fill(std::span(noise), 0, 255);
    packets += believed(reader, noise).size();
  }
  EXPECT_EQ(packets, 0U);
  EXPECT_GT(reader.counters().frames, 0U);  // some noise is COBS; the CRC refuses it
}

}  // namespace
}  // namespace stof::test
