#include "firmware/wire/frame/parity.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "tests/firmware/wire/wire_support.h"

namespace stof::wire {
namespace {

using test::Datagram;
using test::kOrigin;
using test::Random;

constexpr FrameStamp kStamp{
    .number = 7, .freshness = 6, .exposure_middle_ns = -5, .health = Health::kFault};

Datagram seal(const Header& header, std::span<const std::byte> payload) {
  DatagramBuffer buffer{};
  std::ranges::copy(payload, payload_space(buffer).begin());
  const std::span<const std::byte> bytes = seal_packet(header, payload.size(), buffer);
  return {bytes.begin(), bytes.end()};
}

// Parts with every field different from part to part, and their parity packets.
struct Frame {
  Frame(std::uint16_t count, std::uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      const Header header{.type = static_cast<PacketType>(random.between(1, 2)),
                          .flags = static_cast<std::uint8_t>(random.next()),
                          .origin = kOrigin,
                          .frame = kStamp,
                          .stream = static_cast<Stream>(random.between(1, 8)),
                          .codec = static_cast<Codec>(random.between(1, 5)),
                          .index = static_cast<std::uint16_t>(i),
                          .count = count,
                          .image_width = static_cast<std::uint16_t>(random.next()),
                          .image_height = static_cast<std::uint16_t>(random.next()),
                          .first_row = static_cast<std::uint16_t>(random.next()),
                          .first_column = static_cast<std::uint16_t>(random.next()),
                          .pixel_count = static_cast<std::uint16_t>(random.next())};
      const int longest = i % 3 == 0 ? 1 : static_cast<int>(kMaxTilePayload);
      std::vector<std::byte> payload(static_cast<std::size_t>(random.between(0, longest)));
      for (std::byte& byte : payload) {
        byte = static_cast<std::byte>(random.next());
      }
      parts.push_back(seal(header, payload));
    }
    const std::uint16_t groups = parity_groups(count);
    for (std::uint16_t group = 0; group < groups; ++group) {
      ParityGroup sum;
      for (std::size_t i = group; i < count; i += groups) {
        const PacketView part = parse_packet(parts[i]).value();
        EXPECT_EQ(sum.add(part.header, part.payload), Status::kOk);
      }
      DatagramBuffer buffer{};
      const std::size_t bytes = sum.write(count, payload_space(buffer));
      const std::span<const std::byte> payload = payload_space(buffer);
      parity.push_back(seal({.type = PacketType::kParity,
                             .origin = kOrigin,
                             .frame = kStamp,
                             .index = group,
                             .count = groups},
                            payload.first(bytes)));
    }
  }

  std::vector<Datagram> parts;
  std::vector<Datagram> parity;
};

// The group of part `lost` as a receiver gathers it: without that part.
ParityGroup gather(const Frame& frame, std::size_t lost) {
  const std::size_t groups = frame.parity.size();
  ParityGroup group;
  for (std::size_t i = lost % groups; i < frame.parts.size(); i += groups) {
    if (i != lost) {
      const PacketView part = parse_packet(frame.parts[i]).value();
      EXPECT_EQ(group.add(part.header, part.payload), Status::kOk);
    }
  }
  EXPECT_FALSE(group.one_is_missing());
  const Datagram& parity = frame.parity[lost % groups];
  EXPECT_EQ(group.add_parity(parse_packet(parity).value()), Status::kOk);
  return group;
}

TEST(ParityTest, EveryPacketBelongsToOneGroupOfAtMostSixteen) {
  for (int count = 1; count <= 65'535; count += count < 300 ? 1 : 997) {
    const auto packets = static_cast<std::uint16_t>(count);
    int members = 0;
    for (std::uint16_t group = 0; group < parity_groups(packets); ++group) {
      const int here = parity_members(packets, group);
      ASSERT_TRUE(here >= 1 && here <= 16) << count;
      members += here;
    }
    ASSERT_EQ(members, count);
  }
}

TEST(ParityTest, BringsBackEachSingleLoss) {
  for (const int packets : {1, 2, 15, 16, 17, 32, 33, 100}) {
    const auto count = static_cast<std::uint16_t>(packets);
    const Frame frame(count, count);
    for (std::size_t lost = 0; lost < count; ++lost) {
      const ParityGroup group = gather(frame, lost);
      ASSERT_TRUE(group.one_is_missing());
      const Result<PacketView> found = group.recover();
      ASSERT_TRUE(found.has_value()) << lost << " of " << count;
      EXPECT_TRUE(seal(found->header, found->payload) == frame.parts[lost])
          << lost << " of " << count;
    }
  }
}

TEST(ParityTest, TwoLossesOfOneGroupStayLost) {
  const Frame frame(40, 1);
  ParityGroup group;
  for (std::size_t i = 2 * frame.parity.size(); i < frame.parts.size(); i += frame.parity.size()) {
    const PacketView part = parse_packet(frame.parts[i]).value();
    ASSERT_EQ(group.add(part.header, part.payload), Status::kOk);
  }
  ASSERT_EQ(group.add_parity(parse_packet(frame.parity[0]).value()), Status::kOk);
  EXPECT_FALSE(group.one_is_missing());
  EXPECT_EQ(group.recover().error(), Status::kInvalidArgument);
}

// A burst of as many packets as there are groups is brought back whole.
TEST(ParityTest, BringsBackABurst) {
  const Frame frame(160, 5);
  const std::size_t begin = 37;
  for (std::size_t lost = begin; lost < begin + frame.parity.size(); ++lost) {
    const ParityGroup group = gather(frame, lost);
    const Result<PacketView> found = group.recover();
    ASSERT_TRUE(found.has_value());
    EXPECT_TRUE(seal(found->header, found->payload) == frame.parts[lost]) << lost;
  }
}

TEST(ParityTest, RefusesWhatIsNotOfOneFrame) {
  const Frame frame(40, 2);
  const Frame other(40, 3);
  int refused = 0;
  for (std::size_t lost = 0; lost < 40; ++lost) {
    ParityGroup group;
    const std::size_t groups = frame.parity.size();
    for (std::size_t i = lost % groups; i < 40; i += groups) {
      if (i != lost) {
        const PacketView part = parse_packet((i == lost + groups ? other : frame).parts[i]).value();
        ASSERT_EQ(group.add(part.header, part.payload), Status::kOk);
      }
    }
    ASSERT_EQ(group.add_parity(parse_packet(frame.parity[lost % groups]).value()), Status::kOk);
    refused += group.recover().has_value() ? 0 : 1;
  }
  EXPECT_GT(refused, 20);  // the short ones agree by chance
}

TEST(ParityTest, RefusesPacketsThatContradictThemselves) {
  const Frame frame(40, 4);
  const PacketView good = parse_packet(frame.parity[1]).value();
  ParityGroup group;
  EXPECT_EQ(group.add_parity(parse_packet(frame.parts[1]).value()), Status::kCorrupt);
  PacketView bad = good;
  bad.payload = good.payload.first(kParityFieldsBytes - 1);
  EXPECT_EQ(group.add_parity(bad), Status::kCorrupt);
  bad = good;
  bad.header.count = 4;  // of a frame of 40 there are 3
  EXPECT_EQ(group.add_parity(bad), Status::kCorrupt);
  bad = good;
  bad.header.index = 3;
  EXPECT_EQ(group.add_parity(bad), Status::kCorrupt);
  const std::vector<std::byte> long_payload(kMaxParityData + 1);
  EXPECT_EQ(group.add(good.header, long_payload), Status::kTooLarge);
  EXPECT_EQ(group.add_parity(good), Status::kOk);
}

}  // namespace
}  // namespace stof::wire
