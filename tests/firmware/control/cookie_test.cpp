#include "firmware/control/cookie.h"

#include <array>
#include <cstdint>
#include <set>

#include <gtest/gtest.h>

#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/control/requests.h"
#include "tests/support/random.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::Cookies;
using firmware::CookieSecret;
using firmware::siphash24;

CookieSecret counting() {
  CookieSecret key{};
  for (std::size_t i = 0; i < key.size(); ++i) {
    key[i] = static_cast<std::byte>(i);
  }
  return key;
}

// Key 00 01 .. 0f, message 00 01 .. of n bytes. That of 15 bytes stands in the paper's appendix,
// the others in its authors' reference code.
TEST(SipHash, EqualsThePublishedVectors) {
  std::array<std::byte, 64> message{};
  for (std::size_t i = 0; i < message.size(); ++i) {
    message[i] = static_cast<std::byte>(i);
  }
  const auto hash = [&](std::size_t bytes) {
    return siphash24(counting(), std::span(message).first(bytes));
  };
  EXPECT_EQ(hash(15), 0xa129ca6149be45e5);
  EXPECT_EQ(hash(0), 0x726fdb47dd0e0e31);
  EXPECT_EQ(hash(1), 0x74f839c593dc67fd);
  EXPECT_EQ(hash(2), 0x0d6c8009d9a94f5a);
  EXPECT_EQ(hash(7), 0xab0200f58b01d137);
  EXPECT_EQ(hash(8), 0x93f5f5799a932462);
  EXPECT_EQ(hash(63), 0x958a324ceb064572);
}

TEST(Cookies, HoldFor16To32Seconds) {
  const Cookies cookies(counting());
  // kStart is the beginning of a slot: 1,000,000 / 16 = 62,500.
  for (const hal::Duration into :
       {hal::Duration(0ns), hal::Duration(8s), hal::Duration(16s - 1ns)}) {
    const std::uint64_t cookie = cookies.make(peer(1), kStart + into);
    EXPECT_TRUE(cookies.valid(cookie, peer(1), kStart + into));
    EXPECT_TRUE(cookies.valid(cookie, peer(1), kStart + into + 16s));
    EXPECT_TRUE(cookies.valid(cookie, peer(1), kStart + 32s - 1ns));
    EXPECT_FALSE(cookies.valid(cookie, peer(1), kStart + 32s));
    EXPECT_FALSE(cookies.valid(cookie, peer(1), kStart - 1ns));  // of the future
  }
}

TEST(Cookies, AreOfOneAddressPortAndInterface) {
  const Cookies cookies(counting());
  const std::uint64_t cookie = cookies.make(peer(1), kStart);
  EXPECT_FALSE(cookies.valid(cookie, peer(2), kStart));
  EXPECT_FALSE(cookies.valid(cookie, peer(1, 5001), kStart));
  hal::Peer scoped = peer(1);
  scoped.scope = 2;
  EXPECT_FALSE(cookies.valid(cookie, scoped, kStart));
  for (std::size_t i = 0; i < scoped.address.size(); ++i) {
    hal::Peer other = peer(1);
    other.address[i] ^= 0x80;
    EXPECT_FALSE(cookies.valid(cookie, other, kStart)) << "byte " << i;
  }
}

TEST(Cookies, OfAnotherStartAreWorthNothing) {
  CookieSecret other = counting();
  other[7] ^= std::byte{1};
  EXPECT_FALSE(Cookies(counting()).valid(Cookies(other).make(peer(1), kStart), peer(1), kStart));
}

// 100,000 with STOF_LONG=1.
TEST(Cookies, CannotBeGuessed) {
  const Cookies cookies(counting());
  const std::uint64_t cookie = cookies.make(peer(1), kStart);
  constexpr std::uint64_t kSeed = 11;
  Random random(kSeed);
  const int tries = long_or(100'000, 10'000);
  int accepted = 0;
  for (int i = 0; i < tries; ++i) {
    const std::uint64_t near = cookie ^ (std::uint64_t{1} << (random.next() % 64));
    accepted += cookies.valid(random.next(), peer(1), kStart) ? 1 : 0;
    accepted += cookies.valid(near, peer(1), kStart) ? 1 : 0;
  }
  EXPECT_EQ(accepted, 0) << "seed " << kSeed;
}

TEST(Cookies, DifferAndAreNeverNone) {
  const Cookies cookies(counting());
  std::set<std::uint64_t> seen{0};
  for (std::uint16_t port = 1; port <= 1000; ++port) {
    EXPECT_TRUE(seen.insert(cookies.make(peer(1, port), kStart)).second) << port;
  }
}

}  // namespace
}  // namespace stof::test
