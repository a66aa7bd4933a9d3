#include <gtest/gtest.h>

#include "firmware/control/request_handler.h"
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

constexpr hal::Time kStart{1'000'000s};

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
      now += 1ms;
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
    const hal::Peer source = peer(1, static_cast<std::uint16_t>(1 + i));
    const hal::Time now = kStart + 10s + i * 100us;
    answers += handler_.take(subscribe({}), source, now).empty() ? 0 : 1;
  }
  // A full bucket, and what a second refills.
  EXPECT_LE(answers, 2 * static_cast<int>(RequestHandler::kUnprovenPerSecond));
  EXPECT_GE(answers, static_cast<int>(RequestHandler::kUnprovenPerSecond));
  EXPECT_EQ(handler_.counters().busy, static_cast<std::uint64_t>(kRequests - answers));
  const auto proven = subscribed(
      handler_.take(subscribe({.lease_ms = 3000, .cookie = cookie}), peer(200), kStart + 11s));
  ASSERT_TRUE(proven);
  EXPECT_EQ(proven->result, wire::SubscribeResult::kOk);
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
