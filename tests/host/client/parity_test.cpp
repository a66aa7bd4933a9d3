#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/reassembler.h"
#include "tests/host/client/test_pattern.h"

namespace stof::client {
namespace {

using test::Datagram;
using test::frame_spec;
using test::judge;
using test::push_all;

constexpr Time kStart{};
constexpr test::PatternSizes kSizes{};

std::vector<Datagram> packets_of(std::uint32_t number) {
  return test::pattern_datagrams(frame_spec(number), kSizes,
                                 test::every_stream(wire::Coding::kRaw, true, 8));
}

bool is_parity(const Datagram& packet) {
  return wire::parse_packet(packet)->header.type == wire::PacketType::kParity;
}
std::size_t parts_in(const std::vector<Datagram>& packets) {
  return static_cast<std::size_t>(std::ranges::count_if(packets, std::not_fn(is_parity)));
}
std::size_t groups_of(const std::vector<Datagram>& packets) {
  return packets.size() - parts_in(packets);
}

std::vector<Datagram> without(const std::vector<Datagram>& packets,
                              const std::set<std::size_t>& lost) {
  std::vector<Datagram> rest;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    if (!lost.contains(i)) {
      rest.push_back(packets[i]);
    }
  }
  return rest;
}

TEST(Parity, MakesGoodEverySingleLoss) {
  const auto packets = packets_of(1);
  const std::size_t parts = parts_in(packets);
  ASSERT_GT(groups_of(packets), 1U);
  for (std::size_t lost = 0; lost < parts; ++lost) {
    Reassembler reassembler;
    push_all(reassembler, packets_of(0xFFFFFFFF));  // the sender is known to use parity
    const std::optional<Frame> frame = push_all(reassembler, without(packets, {lost}));
    ASSERT_TRUE(frame) << lost;
    EXPECT_TRUE(frame->complete());
    EXPECT_EQ(frame->recovered_packets, 1U);
    EXPECT_TRUE(frame->info);
    EXPECT_EQ(judge(*frame).wrong + judge(*frame).missing, 0U) << lost;
    const Statistics& statistics = reassembler.statistics();
    EXPECT_EQ(statistics.recovered, 1U);
    EXPECT_EQ(statistics.packets_missing, 0U);
    EXPECT_EQ(statistics.frames_complete, 2U);
    EXPECT_EQ(statistics.packets_ok, 2 * packets.size() - 1);
  }
}

// Frame info, which says that parity will come, is the first packet of a frame.
TEST(Parity, MakesGoodTheFirstFrameOfAllOnceItsInfoArrived) {
  const auto packets = packets_of(1);
  Reassembler reassembler;
  const std::optional<Frame> frame = push_all(reassembler, without(packets, {5}));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->recovered_packets, 1U);
  EXPECT_EQ(judge(*frame).wrong, 0U);
}

// No parity packet has arrived yet, but frame info has told of it.
TEST(Parity, IsKnownFromTheFrameBefore) {
  const auto before = packets_of(1);
  Reassembler reassembler;
  const auto parts = static_cast<std::ptrdiff_t>(parts_in(before));
  ASSERT_TRUE(push_all(reassembler, {before.begin(), before.begin() + parts}));
  const std::optional<Frame> frame = push_all(reassembler, without(packets_of(2), {0}));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->info);
  EXPECT_EQ(frame->recovered_packets, 1U);
}

TEST(Parity, MakesGoodABurstOfAsManyPacketsAsThereAreGroups) {
  const auto packets = packets_of(1);
  const std::size_t groups = groups_of(packets);
  for (std::size_t first = 1; first + groups <= parts_in(packets); ++first) {
    std::set<std::size_t> burst;
    for (std::size_t i = 0; i < groups; ++i) {
      burst.insert(first + i);
    }
    Reassembler reassembler;
    const std::optional<Frame> frame = push_all(reassembler, without(packets, burst));
    ASSERT_TRUE(frame) << first;
    EXPECT_EQ(frame->recovered_packets, groups);
    EXPECT_EQ(judge(*frame).wrong + judge(*frame).missing, 0U);
  }
}

TEST(Parity, LeavesTwoLossesOfOneGroupMissing) {
  const auto packets = packets_of(1);
  const std::size_t groups = groups_of(packets);
  Reassembler reassembler;
  EXPECT_FALSE(push_all(reassembler, without(packets, {3, 3 + groups, 4})));
  reassembler.expire(kStart + std::chrono::seconds(1));
  const std::optional<Frame> frame = reassembler.take();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->missing_packets, 2U);
  EXPECT_EQ(frame->recovered_packets, 1U);  // packet 4
  EXPECT_EQ(judge(*frame).wrong, 0U);
  EXPECT_GT(judge(*frame).missing, 0U);
}

TEST(Parity, ComesInAnyOrder) {
  const auto packets = packets_of(2);
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    test::Random random(seed);
    std::set<std::size_t> lost{
        static_cast<std::size_t>(random.between(0, static_cast<int>(parts_in(packets)) - 1))};
    std::vector<Datagram> shuffled = without(packets, lost);
    for (std::size_t i = shuffled.size(); i > 1; --i) {
      std::swap(shuffled[i - 1],
                shuffled[static_cast<std::size_t>(random.between(0, static_cast<int>(i) - 1))]);
    }
    Reassembler reassembler;
    push_all(reassembler, packets_of(1));
    const std::optional<Frame> frame = push_all(reassembler, shuffled);
    ASSERT_TRUE(frame) << seed;
    EXPECT_EQ(judge(*frame).wrong + judge(*frame).missing, 0U) << seed;
    // Parity that came early made more than what was lost; those packets came twice then.
    const Statistics& statistics = reassembler.statistics();
    EXPECT_GE(statistics.recovered, 1U) << seed;
    EXPECT_EQ(statistics.duplicate, statistics.recovered - 1) << seed;
    // What came after the frame was whole is parity that was not needed.
    EXPECT_EQ(statistics.packets_ok + statistics.duplicate, 2 * packets.size() - 1) << seed;
    EXPECT_EQ(statistics.late, 0U) << seed;
  }
}

TEST(Parity, ARecoveredPacketThatArrivesAfterAllIsADuplicate) {
  const auto packets = packets_of(2);
  const std::size_t groups = groups_of(packets);
  Reassembler reassembler;
  push_all(reassembler, packets_of(1));
  // Packet 3 is recovered; 4 and its neighbour keep the frame open.
  push_all(reassembler, without(packets, {3, 4, 4 + groups}));
  EXPECT_EQ(reassembler.statistics().recovered, 1U);
  push_all(reassembler, {packets[3]});
  EXPECT_EQ(reassembler.statistics().duplicate, 1U);
  ASSERT_TRUE(push_all(reassembler, {packets[4]}));  // and its neighbour is recovered
  EXPECT_EQ(reassembler.statistics().recovered, 2U);
  push_all(reassembler, {packets[4 + groups]});
  EXPECT_EQ(reassembler.statistics().duplicate, 2U);
}

TEST(Parity, IsCountedOnceAndByItsCause) {
  const auto packets = packets_of(2);
  const Datagram& parity = packets.back();
  Reassembler reassembler;
  push_all(reassembler, {packets[0], parity, parity});
  EXPECT_EQ(reassembler.statistics().duplicate, 1U);
  push_all(reassembler, packets);
  EXPECT_EQ(reassembler.statistics().frames_complete, 1U);
  // Packet 0, the parity, and the packet that the parity had made before it came.
  EXPECT_EQ(reassembler.statistics().recovered, 1U);
  EXPECT_EQ(reassembler.statistics().duplicate, 4U);
  push_all(reassembler, {parity});  // after the frame
  EXPECT_EQ(reassembler.statistics().duplicate, 5U);
  const Datagram old = packets_of(1).back();  // of a frame that never was
  push_all(reassembler, {old});
  EXPECT_EQ(reassembler.statistics().late, 1U);
  EXPECT_EQ(reassembler.statistics().packets_ok, packets.size() - 1);
}

TEST(Parity, OfAFrameThatClosedWithLossesIsLate) {
  const auto packets = packets_of(1);
  const std::size_t parts = parts_in(packets);
  Reassembler reassembler;
  push_all(reassembler, {packets.begin() + 1, packets.begin() + static_cast<int>(parts)});
  EXPECT_TRUE(push_all(reassembler, packets_of(2)));
  push_all(reassembler, {packets.back()});
  EXPECT_EQ(reassembler.statistics().late, 1U);
}

TEST(Parity, ThatContradictsItsFrameIsRefused) {
  const auto packets = packets_of(2);
  struct Change {
    std::size_t offset;
    int value;
  };
  // Exposure, freshness; then index, count of groups, and the count of parts in its fields.
  for (const Change& change :
       {Change{24, 0x40}, Change{32, 0x40}, Change{38, 0x40}, Change{52, 0x40}}) {
    Datagram other = packets.back();
    other[change.offset] ^= static_cast<std::byte>(change.value);
    test::reseal(other);
    Reassembler reassembler;
    push_all(reassembler, {packets[0], other});
    EXPECT_EQ(reassembler.statistics().bad_field, 1U) << change.offset;
    EXPECT_TRUE(push_all(reassembler, packets)) << change.offset;
    EXPECT_EQ(reassembler.statistics().frames_complete, 1U) << change.offset;
  }
}

// The parity of a lost packet is wrong: what comes of it is judged as if it had arrived.
TEST(Parity, NonsenseIsNotPlaced) {
  const auto packets = packets_of(2);
  for (std::size_t offset = 54; offset < 70; ++offset) {
    Datagram other = packets.back();
    other[offset] ^= std::byte{0xFF};
    test::reseal(other);
    const std::size_t group = wire::parse_packet(other)->header.index;
    std::vector<Datagram> rest = without(packets, {group});
    rest.back() = other;
    Reassembler reassembler;
    push_all(reassembler, packets_of(1));
    push_all(reassembler, rest);
    reassembler.expire(kStart + std::chrono::seconds(1));
    static_cast<void>(reassembler.take());
    EXPECT_LE(reassembler.statistics().recovered, 1U);
    EXPECT_EQ(reassembler.statistics().frames_complete + reassembler.statistics().frames_incomplete,
              2U);
  }
}

TEST(Parity, OfAFrameOfOnePacketIsThatPacket) {
  wire::StreamChoice choice;
  choice.parity = true;
  const auto packets = test::pattern_datagrams(frame_spec(2), {}, choice);
  ASSERT_EQ(packets.size(), 2U);
  Reassembler reassembler;
  push_all(reassembler, packets_of(1));
  const std::optional<Frame> frame = push_all(reassembler, {packets[1]});
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->info);
  EXPECT_EQ(frame->recovered_packets, 1U);
}

}  // namespace
}  // namespace stof::client
