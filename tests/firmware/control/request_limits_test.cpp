#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
#include "tests/firmware/control/handler_parts.h"
#include "tests/firmware/control/requests.h"
#include "tests/support/random.h"

// What somebody can make of the handler who writes a victim's address on requests.
namespace stof::test {
namespace {

using namespace std::chrono_literals;
using firmware::CookieSecret;
using firmware::LeaseTable;
using firmware::RequestHandler;
using firmware::TokenBucket;
using wire::PacketType;

void fill(Bytes& bytes, Random& random) {
  for (std::byte& byte : bytes) {
    byte = static_cast<std::byte>(random.next());
  }
}

class RequestLimits : public testing::Test {
 protected:
  LeaseTable subscribers_;
  RequestHandler handler_{{.device_id = 1}, CookieSecret{}, subscribers_, nullptr};
};

// Every type of packet, known or not, with a payload of every length and any content.
TEST_F(RequestLimits, AnswersNobodyUnprovenWithMoreThanItSent) {
  constexpr std::uint64_t kSeed = 5;
  Random random(kSeed);
  int answers = 0;
  hal::Time now = kStart;
  for (int type = 0; type < 256; ++type) {
    for (std::size_t size = 0; size <= wire::kMaxPayload; size += size < 200 ? 1 : 97) {
      Bytes payload(size);
      fill(payload, random);
      const Bytes request = sealed(static_cast<PacketType>(type), payload);
      now += 5ms;  // as many as one host may ask
      const std::span<const std::byte> answer = handler_.take(request, peer(1), now);
      ASSERT_LE(answer.size(), request.size()) << "type " << type << ", payload " << size;
      answers += answer.empty() ? 0 : 1;
    }
  }
  EXPECT_GT(answers, 4 * 100);
  EXPECT_EQ(subscribers_.count(), 0U);
}

TEST_F(RequestLimits, SaysNothingWhereTheAnswerWouldBeLongerThanTheRequest) {
  const auto answered = [&](PacketType type, std::size_t payload_bytes) {
    return !handler_.take(sealed(type, Bytes(payload_bytes)), peer(1), kStart).empty();
  };
  EXPECT_FALSE(answered(PacketType::kDiscover, wire::kAnnounceBytes - 1));
  EXPECT_EQ(handler_.counters().too_short, 1U);
  EXPECT_TRUE(answered(PacketType::kDiscover, wire::kAnnounceBytes));
  EXPECT_FALSE(answered(PacketType::kSettingsRequest, wire::kSettingsAnswerBytes - 1));
  EXPECT_TRUE(answered(PacketType::kSettingsRequest, wire::kSettingsAnswerBytes));
  EXPECT_FALSE(answered(PacketType::kSubscribe, wire::kSubscribeBytes - 1));
  EXPECT_TRUE(answered(PacketType::kSubscribe, wire::kSubscribeBytes));
}

TEST_F(RequestLimits, AnswersAThousandUnprovenSourcesASecondAndEveryProvenOne) {
  const std::uint64_t cookie =
      subscribed(handler_.take(subscribe({}), peer(200), kStart)).value().cookie;
  int answers = 0;
  constexpr int kRequests = 10'000;  // in a second
  for (int i = 0; i < kRequests; ++i) {
    hal::Peer source = peer(static_cast<std::uint8_t>(i));
    source.address[14] = static_cast<std::uint8_t>(i >> 8);
    const hal::Time now = kStart + 10s + i * 100us;
    answers += handler_.take(subscribe({}), source, now).empty() ? 0 : 1;
  }
  // A full bucket, and what a second refills.
  EXPECT_LE(answers, 2 * static_cast<int>(firmware::RequestLimits::kUnprovenPerSecond));
  EXPECT_GE(answers, static_cast<int>(firmware::RequestLimits::kUnprovenPerSecond));
  EXPECT_EQ(handler_.counters().busy, static_cast<std::uint64_t>(kRequests - answers));
  const auto proven = subscribed(
      handler_.take(subscribe({.lease_ms = 3000, .cookie = cookie}), peer(200), kStart + 11s));
  ASSERT_TRUE(proven);
  EXPECT_EQ(proven->result, wire::SubscribeResult::kOk);
}

// 5,000 requests a second from one address and all of its ports, with somebody else beside them.
TEST_F(RequestLimits, OneHostThatFloodsKeepsNobodyElseOut) {
  int others = 0;
  int answers = 0;
  constexpr int kRequests = 50'000;  // in ten seconds
  for (int i = 0; i < kRequests; ++i) {
    const hal::Time now = kStart + i * 200us;
    const hal::Peer attacker = peer(66, static_cast<std::uint16_t>(1 + i % 60'000));
    answers += handler_.take(subscribe({}), attacker, now).empty() ? 0 : 1;
    if (i % 5000 == 4999) {  // once a second
      const auto answer = subscribed(handler_.take(subscribe({}), peer(7), now));
      ASSERT_TRUE(answer) << i;
      const auto proven =
          subscribed(handler_.take(subscribe({.cookie = answer->cookie}), peer(7), now));
      ASSERT_TRUE(proven) << i;
      others += proven->result == wire::SubscribeResult::kOk ? 1 : 0;
    }
  }
  EXPECT_EQ(others, 10);
  EXPECT_LE(answers, 11 * static_cast<int>(firmware::RequestLimits::kUnprovenPerHost));
}

// Nor one that has proven its address, whatever it asks for.
TEST_F(RequestLimits, AProvenHostIsServedAThousandTimesASecond) {
  const std::uint64_t cookie =
      subscribed(handler_.take(subscribe({}), peer(66), kStart)).value().cookie;
  int served = 0;
  for (int i = 0; i < 20'000; ++i) {
    served +=
        handler_.take(settings({.cookie = cookie}), peer(66), kStart + i * 100us).empty() ? 0 : 1;
  }
  EXPECT_GE(served, 2 * static_cast<int>(firmware::RequestLimits::kProvenPerHost));
  EXPECT_LE(served, 3 * static_cast<int>(firmware::RequestLimits::kProvenPerHost));
}

// All hosts of a link have one IPv6 network: one of them must not take what the others have.
TEST(SourceLimiter, AnAddressThatFloodsLeavesTheOthersOfItsIpv6Network) {
  constexpr std::uint32_t kPerSecond = 100;
  firmware::SourceLimiter limiter(firmware::CookieSecret{std::byte{3}}, kPerSecond);
  const auto address = [](std::uint8_t last) {
    return hal::Peer{.address = {0xFD, 0x77, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, last}};
  };
  int flooder = 0;
  int victim = 0;
  for (int i = 0; i < 10'000; ++i) {
    const hal::Time now = kStart + i * 1ms;
    flooder += limiter.take(address(1), now) ? 1 : 0;
    victim += i % 100 == 0 && limiter.take(address(2), now) ? 1 : 0;
  }
  EXPECT_EQ(victim, 100) << "10 a second";
  EXPECT_LE(flooder, 11 * static_cast<int>(kPerSecond));
  // Whoever has many addresses has what some hosts have, and no more.
  int all = 0;
  for (int i = 0; i < 10'000; ++i) {
    all += limiter.take(address(static_cast<std::uint8_t>(i)), kStart + 100s + i * 1ms) ? 1 : 0;
  }
  EXPECT_LE(all, 11 * static_cast<int>(firmware::SourceLimiter::kAddressesOfNetwork * kPerSecond));
}

TEST(SourceLimiter, AHostIsAnAddressOrAnIpv6Network) {
  using firmware::host_of;
  EXPECT_EQ(host_of(peer(1, 1)), host_of(peer(1, 2)));
  EXPECT_NE(host_of(peer(1)), host_of(peer(2)));
  const auto ipv6 = [](std::uint8_t first, std::uint8_t second, std::uint8_t network,
                       std::uint8_t last) {
    return hal::Peer{.address = {first, second, 0, 0, 0, 0, 0, network, 0, 0, 0, 0, 0, 0, 0, last}};
  };
  EXPECT_EQ(host_of(ipv6(0x20, 0x01, 5, 1)), host_of(ipv6(0x20, 0x01, 5, 2)));
  EXPECT_NE(host_of(ipv6(0x20, 0x01, 5, 1)), host_of(ipv6(0x20, 0x01, 6, 1)));
  EXPECT_NE(host_of(ipv6(0xFE, 0x80, 0, 1)), host_of(ipv6(0xFE, 0x80, 0, 2)));
}

TEST(TokenBucket, LetsSomePassThenOneAtATime) {
  TokenBucket bucket(3, 60s);
  int passed = 0;
  for (int second = 0; second < 600; ++second) {
    passed += bucket.take(kStart + second * 1s) ? 1 : 0;
  }
  EXPECT_EQ(passed, 3 + 9);
}

TEST(TokenBucket, LetsAFullSecondPassThenItsRate) {
  TokenBucket bucket(10);
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(bucket.take(kStart));
  }
  EXPECT_FALSE(bucket.take(kStart));
  EXPECT_FALSE(bucket.take(kStart + 99ms));
  EXPECT_TRUE(bucket.take(kStart + 100ms));
  EXPECT_FALSE(bucket.take(kStart + 100ms));
  for (int i = 0; i < 10; ++i) {
    EXPECT_TRUE(bucket.take(kStart + 10s));
  }
  EXPECT_FALSE(bucket.take(kStart + 10s));
}

// Any bytes, and real requests with some bytes changed. 1,000,000 with STOF_LONG=1.
TEST_F(RequestLimits, CountsEveryDatagramOnceWhateverItHolds) {
  constexpr std::uint64_t kSeed = 7;
  Random random(kSeed);
  const std::vector<Bytes> requests{subscribe({}), settings({}, "{}"), discover(1),
                                    subscribe({}, PacketType::kUnsubscribe)};
  const int rounds = long_or(1'000'000, 20'000);
  for (int i = 0; i < rounds; ++i) {
    Bytes bytes;
    if (i % 2 == 0) {
      bytes.resize(static_cast<std::size_t>(random.between(0, 1400)));
      fill(bytes, random);
    } else {
      bytes = requests[random.next() % requests.size()];
      bytes[random.next() % bytes.size()] ^= static_cast<std::byte>(random.next());
      bytes.resize(bytes.size() - random.next() % 3);
    }
    handler_.take(bytes, peer(1), kStart + i * 1ms);
  }
  const wire::ControlCounters counted = handler_.counters();
  const std::uint64_t sum = counted.accepted + counted.truncated + counted.bad_magic +
                            counted.bad_version + counted.bad_length + counted.bad_crc +
                            counted.bad_field + counted.not_control + counted.foreign +
                            counted.too_short + counted.cookies + counted.busy;
  EXPECT_EQ(sum, static_cast<std::uint64_t>(rounds)) << "seed " << kSeed;
  EXPECT_EQ(subscribers_.count(), 0U);
}

}  // namespace
}  // namespace stof::test
