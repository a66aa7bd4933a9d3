#include "host/client/raw/raw_assembler.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/reassembler.h"
#include "tests/host/client/sent_frame.h"
#include "tests/support/random.h"

namespace stof::client {
namespace {

using namespace std::chrono_literals;
using test::Datagram;

constexpr Time kStart{1000s};
constexpr int kWidth = 64;
constexpr int kHeight = 50;
constexpr int kPmdWidth = 16;
constexpr int kPmdHeight = 12;

// One exposure's pictures: random, others for each id.
struct Exposure {
  explicit Exposure(std::uint32_t freshness) : id(freshness) {
    test::Random random(freshness);
    for (auto* eye : {&left, &right}) {
      for (std::uint8_t& pixel : *eye) {
        pixel = static_cast<std::uint8_t>(random.between(0, 255));
      }
    }
    for (std::uint16_t& sample : samples) {
      sample = static_cast<std::uint16_t>(random.between(0, 65'535));
    }
  }
  wire::RawImages images() const {
    wire::RawImages all{.left = {left.data(), kWidth, kHeight},
                        .right = {right.data(), kWidth, kHeight},
                        .samples = {}};
    for (std::size_t k = 0; k < wire::kRawSamples; ++k) {
      all.samples.at(k) = {samples.data() + k * kPmdWidth * kPmdHeight, kPmdWidth, kPmdHeight};
    }
    return all;
  }
  std::vector<Datagram> packets(std::uint32_t number, std::uint32_t dropped = 0,
                                const wire::Origin& origin = test::kOrigin) const {
    const wire::RawPackets sealed(
        origin, {.number = id + 7, .freshness = id, .exposure_middle_ns = 1'000 * id}, images(), {},
        {.edge_ns = 5, .number = number, .dropped = dropped});
    std::vector<Datagram> all;
    for (std::size_t i = 0; i < sealed.count(); ++i) {
      wire::DatagramBuffer buffer;
      const std::span<const std::byte> packet = sealed.seal(i, buffer);
      all.emplace_back(packet.begin(), packet.end());
    }
    return all;
  }

  std::uint32_t id;
  std::vector<std::uint8_t> left = std::vector<std::uint8_t>(kWidth * kHeight);
  std::vector<std::uint8_t> right = std::vector<std::uint8_t>(kWidth * kHeight);
  std::vector<std::uint16_t> samples = std::vector<std::uint16_t>(4 * kPmdWidth * kPmdHeight);
};

bool equal(const RawExposure& got, const Exposure& sent, std::uint8_t pictures) {
  const auto eye = [&](const auto& view, const std::vector<std::uint8_t>& pixels,
                       std::uint8_t bit) {
    return (pictures & bit) == 0 ? view.empty() : test::same_pixels(view, pixels);
  };
  bool same = eye(got.left, sent.left, wire::kRawLeft) &&
              eye(got.right, sent.right, wire::kRawRight) && got.stamp.freshness == sent.id;
  for (std::size_t k = 0; k < wire::kRawSamples; ++k) {
    const std::span<const std::uint16_t> one =
        std::span(sent.samples).subspan(k * kPmdWidth * kPmdHeight, kPmdWidth * kPmdHeight);
    const auto& view = got.pmd.at(k);
    same = same && ((pictures & wire::kRawPmd) == 0
                        ? view.empty()
                        : test::same_pixels(view, std::vector(one.begin(), one.end())));
  }
  return same;
}

class RawAssemblerTest : public testing::Test {
 protected:
  RawOutcome push(const Datagram& datagram, Time arrived = kStart) {
    return raw_.push(wire::parse_packet(datagram).value(), arrived);
  }
  void push_all(const std::vector<Datagram>& datagrams, Time arrived = kStart) {
    for (const Datagram& datagram : datagrams) {
      EXPECT_EQ(push(datagram, arrived), RawOutcome::kTaken);
    }
  }

  RawAssembler raw_{std::size_t{1} << 16};
};

TEST_F(RawAssemblerTest, WholeExposuresComeBitForBitInAnyOrderOfTheirPackets) {
  test::Random random(3);
  for (std::uint32_t n = 1; n <= 20; ++n) {
    const Exposure sent(n);
    std::vector<Datagram> packets = sent.packets(n);
    for (std::size_t i = packets.size(); i > 1; --i) {
      std::swap(packets[i - 1],
                packets[static_cast<std::size_t>(random.between(0, static_cast<int>(i) - 1))]);
    }
    push_all(packets);
    const std::optional<RawExposure> got = raw_.take();
    ASSERT_TRUE(got);
    EXPECT_TRUE(got->complete());
    EXPECT_EQ(got->info.edge_ns, 5);
    EXPECT_EQ(got->stamp.number, n + 7);
    EXPECT_TRUE(equal(*got, sent, wire::kRawPictures));
    EXPECT_FALSE(raw_.take());
  }
  EXPECT_EQ(raw_.statistics().complete, 20U);
  EXPECT_EQ(raw_.statistics().lost, 0U);
}

// Whichever packet is lost: its picture is missing, and no other one.
TEST_F(RawAssemblerTest, APictureThatMissesAPacketIsMissing) {
  std::uint32_t n = 0;
  const std::size_t count = Exposure(1).packets(1).size();
  for (std::size_t lost = 1; lost < count; ++lost) {
    const Exposure sent(++n);
    std::vector<Datagram> packets = sent.packets(n);
    const wire::Stream stream = wire::parse_packet(packets[lost])->header.stream;
    const auto bit = static_cast<std::uint8_t>(
        1U << (static_cast<unsigned>(stream) - static_cast<unsigned>(wire::Stream::kRawLeft)));
    packets.erase(packets.begin() + static_cast<std::ptrdiff_t>(lost));
    push_all(packets);
    EXPECT_FALSE(raw_.take()) << "it may come yet";
    raw_.expire(kStart + RawAssembler::kTimeout);
    const std::optional<RawExposure> got = raw_.take();
    ASSERT_TRUE(got);
    EXPECT_EQ(got->missing, bit);
    EXPECT_TRUE(equal(*got, sent, static_cast<std::uint8_t>(wire::kRawPictures & ~bit)));
  }
  EXPECT_EQ(raw_.statistics().incomplete, n);
  EXPECT_EQ(raw_.statistics().complete, 0U);
}

TEST_F(RawAssemblerTest, WithoutItsInfoNothingIsDelivered) {
  for (std::uint32_t n = 1; n <= 3; ++n) {
    std::vector<Datagram> packets = Exposure(n).packets(n);
    if (n == 2) {
      packets.erase(packets.begin());
    }
    push_all(packets);
  }
  EXPECT_EQ(raw_.take()->stamp.freshness, 1U);
  EXPECT_EQ(raw_.take()->stamp.freshness, 3U);
  EXPECT_EQ(raw_.statistics().lost, 1U);
}

TEST_F(RawAssemblerTest, ALaterWholeOneFinishesAnEarlierOneAndAThirdTheOldest) {
  const Exposure first(1), second(2), third(3);
  std::vector<Datagram> one = first.packets(1);
  const Datagram late = one.back();
  one.pop_back();
  push_all(one);
  push_all(second.packets(2));
  EXPECT_TRUE(equal(raw_.take().value(), first, wire::kRawLeft | wire::kRawRight));
  EXPECT_TRUE(equal(raw_.take().value(), second, wire::kRawPictures));
  EXPECT_EQ(push(late), RawOutcome::kLate);
  for (std::uint32_t n = 3; n <= 5; ++n) {
    EXPECT_EQ(push(Exposure(n).packets(n).front()), RawOutcome::kTaken);
  }
  EXPECT_EQ(raw_.take()->stamp.freshness, 3U);
  EXPECT_FALSE(raw_.take());
}

TEST_F(RawAssemblerTest, NumbersTellWhatWasLostAndTheSensorWhatItDropped) {
  push_all(Exposure(1).packets(4, 2));  // of a subscription that goes on
  push_all(Exposure(2).packets(5, 2));
  push_all(Exposure(3).packets(9, 7));
  while (raw_.take()) {
  }
  EXPECT_EQ(raw_.statistics().lost, 3U);
  EXPECT_EQ(raw_.statistics().dropped, 7U);
  push_all(Exposure(4).packets(1, 1));  // asked for anew
  push_all(Exposure(5).packets(2, 1));
  EXPECT_EQ(raw_.statistics().lost, 3U);
  EXPECT_EQ(raw_.statistics().dropped, 8U);
}

TEST_F(RawAssemblerTest, WhatNobodyTakesMakesRoomAndIsCounted) {
  for (std::uint32_t n = 1; n <= 8; ++n) {
    push_all(Exposure(n).packets(n));
  }
  std::uint64_t taken = 0;
  std::uint32_t newest = 0;
  while (const std::optional<RawExposure> got = raw_.take()) {
    ++taken;
    newest = got->stamp.freshness;
  }
  EXPECT_EQ(newest, 8U);
  EXPECT_EQ(taken + raw_.statistics().untaken, 8U);
  EXPECT_GE(taken, 2U);
}

TEST_F(RawAssemblerTest, WhatContradictsIsRefused) {
  const Exposure sent(1);
  const std::vector<Datagram> packets = sent.packets(1);
  ASSERT_EQ(push(packets[0]), RawOutcome::kTaken);
  ASSERT_EQ(push(packets[1]), RawOutcome::kTaken);
  EXPECT_EQ(push(packets[1]), RawOutcome::kDuplicate);
  const auto changed = [&](std::size_t packet, std::size_t at, std::uint8_t value) {
    Datagram bytes = packets[packet];
    bytes[at] = std::byte{value};
    test::reseal(bytes);
    return push(bytes);
  };
  constexpr std::size_t kStream = 16, kIndex = 36, kCount = 38, kImageWidth = 40, kFirstRow = 44;
  EXPECT_EQ(changed(2, kCount, 99), RawOutcome::kContradicting);
  EXPECT_EQ(changed(2, kFirstRow, 0), RawOutcome::kContradicting) << "pixels that came already";
  EXPECT_EQ(changed(2, kImageWidth, 32), RawOutcome::kContradicting) << "another size";
  EXPECT_EQ(changed(2, kFirstRow + 1, 200), RawOutcome::kContradicting) << "outside";
  EXPECT_EQ(changed(2, kIndex, 0), RawOutcome::kContradicting) << "the info's place";
  EXPECT_EQ(changed(0, kIndex, 3), RawOutcome::kContradicting);
  EXPECT_EQ(changed(2, kStream, 1), RawOutcome::kUnknown) << "no raw stream";
  EXPECT_EQ(changed(2, kStream + 1, 4), RawOutcome::kUnknown) << "a codec of a newer sensor";
  EXPECT_EQ(changed(2, kImageWidth + 1, 200), RawOutcome::kOversized);
  for (std::size_t i = 2; i < packets.size(); ++i) {
    EXPECT_EQ(push(packets[i]), RawOutcome::kTaken);
  }
  EXPECT_TRUE(equal(raw_.take().value(), sent, wire::kRawPictures));
}

// Tiles that somebody else makes before the sensor's, of one exposure or of many ahead.
TEST_F(RawAssemblerTest, WhoMakesPicturesBeforeTheSensorIsTold) {
  for (const std::uint32_t ahead : {1U, 5U, 100U}) {
    raw_ = RawAssembler(std::size_t{1} << 16);
    const auto forged = [](std::uint32_t id) {
      std::vector<Datagram> packets = Exposure(id).packets(id);
      for (Datagram& packet : packets) {
        packet[wire::kHeaderBytes] ^= std::byte{1};
        test::reseal(packet);
      }
      return packets;
    };
    for (std::uint32_t id = 1; id <= ahead; ++id) {
      push_all(forged(id));
      EXPECT_TRUE(raw_.take());
    }
    EXPECT_EQ(raw_.lies(), 0U);
    for (const Datagram& packet : Exposure(1).packets(1)) {
      push(packet);
    }
    EXPECT_GT(raw_.lies(), 0U) << ahead;
    EXPECT_FALSE(raw_.take());
  }
}

TEST_F(RawAssemblerTest, AnotherExposureOfTheSameIdIsALie) {
  push_all(Exposure(1).packets(1));
  Datagram other = Exposure(1).packets(1)[2];
  constexpr std::size_t kExposureMiddle = 24;
  other[kExposureMiddle] ^= std::byte{1};
  test::reseal(other);
  EXPECT_EQ(push(other), RawOutcome::kContradicting);
  EXPECT_EQ(raw_.lies(), 1U);
}

TEST_F(RawAssemblerTest, WhatTheNetworkRepeatsIsNoLie) {
  for (std::uint32_t id = 1; id < 10; ++id) {
    push_all(Exposure(id).packets(id));
    for (std::uint32_t k = 1; k <= id; ++k) {
      for (const Datagram& packet : Exposure(k).packets(k)) {
        EXPECT_EQ(push(packet), RawOutcome::kLate);
      }
    }
    EXPECT_TRUE(raw_.take());
  }
  EXPECT_EQ(raw_.lies(), 0U);
}

// Of a picture that is not of the size that its info tells nothing is believed.
TEST_F(RawAssemblerTest, APictureOfAnotherSizeThanItsInfoTellsIsMissing) {
  std::vector<Datagram> packets = Exposure(1).packets(1);
  packets[0][wire::kHeaderBytes + 124] = std::byte{kWidth / 2};  // width
  packets[0][wire::kHeaderBytes + 136] = std::byte{kPmdWidth / 2};
  test::reseal(packets[0]);
  push_all(packets);
  const std::optional<RawExposure> got = raw_.take();
  ASSERT_TRUE(got);
  EXPECT_EQ(got->missing, wire::kRawPictures);
  EXPECT_TRUE(got->left.empty() && got->right.empty() && got->pmd[0].empty());
}

TEST_F(RawAssemblerTest, ExpiresTwoSecondsAfterItsLastPacket) {
  EXPECT_FALSE(raw_.next_expiry());
  const std::vector<Datagram> packets = Exposure(1).packets(1);
  push(packets[0], kStart);
  push(packets[1], kStart + 1s);
  EXPECT_EQ(raw_.next_expiry(), kStart + 1s + RawAssembler::kTimeout);
  raw_.expire(kStart + 3s - 1ns);
  EXPECT_FALSE(raw_.take());
  raw_.expire(kStart + 3s);
  EXPECT_TRUE(raw_.take());
}

// Nobody makes a receiver take memory for what it did not ask for.
TEST(RawReassembly, WhatNobodyAskedForIsUnknown) {
  Reassembler reassembler;
  const std::vector<Datagram> packets = Exposure(1).packets(1);
  for (const Datagram& datagram : packets) {
    reassembler.push(datagram, kStart);
  }
  EXPECT_EQ(reassembler.statistics().unknown, packets.size());
  EXPECT_FALSE(reassembler.raw().take());
  EXPECT_FALSE(reassembler.next_expiry());
}

// Beside the frames, through all that a datagram passes.
TEST(RawReassembly, EveryDatagramIsCountedOnceAndAnotherSessionBeginsAnew) {
  Reassembler reassembler({.max_pixels = std::size_t{1} << 16, .raw_pictures = true});
  reassembler.expect(test::kOrigin);
  const Exposure sent(1);
  std::vector<Datagram> packets = sent.packets(1);
  std::uint64_t pushed = 0;
  const auto push = [&](const Datagram& datagram) {
    reassembler.push(datagram, kStart + std::chrono::milliseconds(pushed));
    ++pushed;
  };
  std::ranges::for_each(packets, push);
  push(packets.front());
  packets[2][100] ^= std::byte{1};
  push(packets[2]);
  EXPECT_TRUE(equal(reassembler.raw().take().value(), sent, wire::kRawPictures));
  EXPECT_EQ(reassembler.statistics().packets_ok, packets.size());
  EXPECT_EQ(reassembler.statistics().late, 1U);
  EXPECT_EQ(reassembler.statistics().bad_crc, 1U);
  EXPECT_EQ(reassembler.statistics().packets(), pushed);
  push(Exposure(2).packets(2).front());
  wire::Origin other = test::kOrigin;
  ++other.session_id;
  reassembler.expect(other);
  for (const Datagram& datagram : sent.packets(1, 0, other)) {
    push(datagram);
  }
  EXPECT_TRUE(equal(reassembler.raw().take().value(), sent, wire::kRawPictures));
  EXPECT_EQ(reassembler.raw().statistics().untaken, 1U);
  EXPECT_EQ(reassembler.raw().statistics().complete, 2U);
}

}  // namespace
}  // namespace stof::client
