// Damage is refused. STOF_LONG=1: all single bits of 100 packets and a million of each other kind.
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/reassembler.h"
#include "tests/host/client/test_pattern.h"
#include "tests/support/long_tests.h"

namespace stof::client {
namespace {

using test::Datagram;

constexpr std::size_t kByteBits = 8;

// Packets of every stream, coded and raw, with parity.
const std::vector<Datagram>& packets() {
  static const std::vector<Datagram> all = [] {
    std::vector<Datagram> made;
    for (const wire::Coding coding : {wire::Coding::kRvl, wire::Coding::kRaw}) {
      for (const Datagram& packet :
           test::pattern_datagrams(test::frame_spec(3), {.width = 320, .height = 100},
                                   test::every_stream(coding, true, 8))) {
        made.push_back(packet);
      }
    }
    return made;
  }();
  return all;
}

std::size_t rounds() { return test::long_tests() ? 1'000'000 : 20'000; }

// In the order in which the CRC sees them.
void flip(Datagram& packet, std::size_t bit) {
  packet[bit / kByteBits] ^= std::byte{1} << (bit % kByteBits);
}

std::size_t below(test::Random& random, std::size_t count) { return random.next() % count; }

class Damage : public testing::Test {
 protected:
  void push(const Datagram& packet) {
    reassembler_.push(packet, Time{});
    ++pushed_;
  }
  ~Damage() override {
    const Statistics& statistics = reassembler_.statistics();
    EXPECT_EQ(statistics.truncated + statistics.bad_magic + statistics.bad_version +
                  statistics.bad_length + statistics.bad_crc,
              pushed_);
    EXPECT_EQ(statistics.packets(), pushed_);
    EXPECT_FALSE(reassembler_.next_expiry());
    EXPECT_GT(pushed_, 1000U);
  }

  Reassembler reassembler_;
  std::uint64_t pushed_ = 0;
};

TEST_F(Damage, EverySingleBitIsRefused) {
  const std::size_t count = test::long_tests() ? 100 : 3;
  ASSERT_GE(packets().size(), 100U);
  for (std::size_t i = 0; i < count; ++i) {
    Datagram packet = packets()[i * packets().size() / count];
    for (std::size_t bit = 0; bit < packet.size() * kByteBits; ++bit) {
      flip(packet, bit);
      push(packet);
      flip(packet, bit);
    }
  }
}

TEST_F(Damage, TwoAndThreeBitsAreRefused) {
  test::Random random(1);
  for (std::size_t i = 0; i < rounds(); ++i) {
    Datagram packet = packets()[below(random, packets().size())];
    const std::size_t bits = packet.size() * kByteBits;
    const std::size_t first = below(random, bits);
    const std::size_t second = (first + 1 + below(random, bits - 1)) % bits;
    flip(packet, first);
    flip(packet, second);
    if (const std::size_t third = below(random, bits); third != first && third != second) {
      flip(packet, third);
    }
    push(packet);
  }
}

TEST_F(Damage, BurstsOfUpTo32BitsAreRefused) {
  test::Random random(2);
  for (std::size_t i = 0; i < rounds(); ++i) {
    Datagram packet = packets()[below(random, packets().size())];
    const std::size_t length = 2 + below(random, 31);
    const std::size_t first = below(random, packet.size() * kByteBits - length + 1);
    const std::uint64_t pattern = random.next() | 1 | (std::uint64_t{1} << (length - 1));
    for (std::size_t k = 0; k < length; ++k) {
      if (((pattern >> k) & 1) != 0) {
        flip(packet, first + k);
      }
    }
    push(packet);
  }
}

TEST_F(Damage, EveryTruncationIsRefused) {
  const std::size_t step = test::long_tests() ? 1 : packets().size() / 20;
  for (std::size_t i = 0; i < packets().size(); i += step) {
    const Datagram& packet = packets()[i];
    for (std::size_t size = 0; size < packet.size(); ++size) {
      push({packet.begin(), packet.begin() + static_cast<std::ptrdiff_t>(size)});
    }
  }
}

TEST_F(Damage, EveryTailIsRefused) {
  for (Datagram packet : packets()) {
    for (int more = 0; more < 8; ++more) {
      packet.push_back(std::byte{0});
      push(packet);
    }
  }
}

}  // namespace
}  // namespace stof::client
