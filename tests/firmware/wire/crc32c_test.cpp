#include "firmware/wire/crc32c.h"

#include <string_view>

#include <gtest/gtest.h>

#include "firmware/wire/crc32c_hardware.h"
#include "tests/support/guarded_memory.h"
#include "tests/support/random.h"

namespace stof::wire {
namespace {

std::span<const std::byte> bytes_of(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

// The meaning: one bit at a time, as the polynomial is written.
std::uint32_t bitwise(std::span<const std::byte> bytes) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (const std::byte byte : bytes) {
    crc ^= std::to_integer<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0x82F63B78U : 0U);
    }
  }
  return ~crc;
}

TEST(Crc32c, GivesTheKnownAnswers) {
  EXPECT_EQ(crc32c(bytes_of("123456789")), 0xE3069283U);
  EXPECT_EQ(crc32c({}), 0U);
  EXPECT_EQ(crc32c(bytes_of("a")), 0xC1D04330U);
  // RFC 3720, appendix B.4: 32 bytes of zeros, of ones, counting up, counting down.
  std::array<std::byte, 32> bytes{};
  EXPECT_EQ(crc32c(bytes), 0x8A9136AAU);
  bytes.fill(std::byte{0xFF});
  EXPECT_EQ(crc32c(bytes), 0x62A8AB43U);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::byte>(i);
  }
  EXPECT_EQ(crc32c(bytes), 0x46DD794EU);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<std::byte>(31 - i);
  }
  EXPECT_EQ(crc32c(bytes), 0x113FDB5CU);
}

TEST(Crc32c, EqualsOneBitAtATimeForEveryLength) {
  test::Random random(1);
  for (std::size_t length = 0; length <= 300; ++length) {
    test::GuardedBuffer<std::byte> bytes(length);
    for (std::byte& byte : bytes.span()) {
      byte = static_cast<std::byte>(random.next());
    }
    ASSERT_EQ(crc32c(bytes.span()), bitwise(bytes.span())) << "length " << length;
  }
}

// Up to more than two turns of each loop, and a datagram.
TEST(Crc32c, EveryVariantIsTheSameForEveryLengthAndAlignment) {
  if (!hardware::available()) {
    GTEST_SKIP() << "this processor has no instruction for it";
  }
  constexpr std::size_t kMost = 2200;
  test::GuardedBuffer<std::byte> bytes(kMost);
  test::Random random(3);
  for (std::byte& byte : bytes.span()) {
    byte = static_cast<std::byte>(random.next());
  }
  for (std::size_t length = 0; length <= kMost; ++length) {
    for (std::size_t offset = 0; offset < 9 && offset + length <= kMost; ++offset) {
      // Ends at an unreadable page first.
      const auto part = bytes.span().last(offset + length).first(length);
      const auto before = static_cast<std::uint32_t>(random.next());
      ASSERT_EQ(hardware::crc32c(part, before), table::crc32c(part, before))
          << "length " << length << " at " << offset;
    }
  }
}

TEST(Crc32c, GoesOnWhereItStopped) {
  test::GuardedBuffer<std::byte> bytes(64);
  test::Random random(2);
  for (std::byte& byte : bytes.span()) {
    byte = static_cast<std::byte>(random.next());
  }
  const std::span<const std::byte> all = bytes.span();
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    ASSERT_EQ(crc32c(all.subspan(cut), crc32c(all.first(cut))), crc32c(all)) << "cut " << cut;
  }
}

}  // namespace
}  // namespace stof::wire
