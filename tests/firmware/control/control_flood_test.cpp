#include <gtest/gtest.h>

#include "tests/firmware/control/control_client.h"
#include "tests/firmware/control/sensor.h"
#include "tests/support/random.h"
#include "tests/support/udp_abilities.h"

// A sender of rubbish against the port that a subscriber depends on.
namespace stof::test {
namespace {

using namespace std::chrono_literals;
using wire::PacketType;
using wire::SubscribeResult;

struct Kind {
  Bytes datagram;
  std::uint64_t wire::ControlCounters::* counter;
};

// One of each way to be wrong.
std::vector<Kind> rubbish() {
  const Bytes good = subscribe({});
  const auto changed = [&](std::size_t at) {
    Bytes bytes = good;
    bytes[at] ^= std::byte{0x40};
    return bytes;
  };
  Bytes longer = good;
  longer.push_back({});
  return {{Bytes{}, &wire::ControlCounters::truncated},
          {Bytes(good.begin(), good.end() - 5), &wire::ControlCounters::truncated},
          {changed(1), &wire::ControlCounters::bad_magic},
          {Bytes(wire::kMaxDatagram, std::byte{0xFF}), &wire::ControlCounters::bad_magic},
          {changed(4), &wire::ControlCounters::bad_version},
          {longer, &wire::ControlCounters::bad_length},
          {Bytes(1400, std::byte{'S'}), &wire::ControlCounters::bad_length},
          {changed(60), &wire::ControlCounters::bad_crc},
          {sealed(PacketType::kSubscribe, Bytes(20)), &wire::ControlCounters::bad_field},
          {sealed(PacketType::kTile, Bytes(100)), &wire::ControlCounters::not_control},
          {subscribe({}, PacketType::kSubscribe, 12345), &wire::ControlCounters::foreign},
          {sealed(PacketType::kDiscover, Bytes(4)), &wire::ControlCounters::too_short}};
}

// 10,000,000 with STOF_LONG=1.
TEST(ControlFlood, IsCountedByReasonAndCostsNoSubscriberItsLease) {
  Sensor sensor;
  ControlClient robot(sensor);
  ControlClient attacker(sensor);
  ASSERT_EQ(robot.ask(), SubscribeResult::kOk);
  const std::vector<Kind> kinds = rubbish();
  constexpr std::uint64_t kSeed = 3;
  Random random(kSeed);
  const int rounds = long_or(10'000'000, 100'000);
  std::vector<std::uint64_t> sent(kinds.size());
  auto renewal = std::chrono::steady_clock::now();
  int renewals = 0;
  const auto refused = [&] {
    const wire::ControlCounters counters = control_counters(sensor.handler, *sensor.port);
    return counters.truncated + counters.bad_magic + counters.bad_version + counters.bad_length +
           counters.bad_crc + counters.bad_field + counters.not_control + counters.foreign +
           counters.too_short;
  };
  // Every second; with a lease that this computer may be busy for.
  const auto renew = [&] {
    if (std::chrono::steady_clock::now() > renewal) {
      ASSERT_EQ(robot.ask(PacketType::kSubscribe, 10'000), SubscribeResult::kOk);
      ++renewals;
      renewal = std::chrono::steady_clock::now() + 1s;
    }
  };
  std::uint64_t flood = 0;
  for (int i = 0; i < rounds; ++i) {
    const std::size_t kind = random.next() % kinds.size();
    // Not more in flight than a socket holds that is granted no more than usual: what it loses is
    // counted without a reason.
    if (i % 16 == 0) {
      for (int k = 0; k < 60'000 && flood > refused() + 100; ++k) {
        std::this_thread::sleep_for(1ms);
        ASSERT_NO_FATAL_FAILURE(renew()) << "after " << i;
      }
    }
    if (attacker.send_any(kinds[kind].datagram)) {
      ++sent[kind];
      ++flood;
    }
    ASSERT_NO_FATAL_FAILURE(renew()) << "after " << i;
  }
  for (int k = 0; k < 60'000 && refused() < flood; ++k) {
    std::this_thread::sleep_for(1ms);
    ASSERT_NO_FATAL_FAILURE(renew());
  }
  const wire::ControlCounters counters = control_counters(sensor.handler, *sensor.port);
  for (std::uint64_t wire::ControlCounters::* const counter :
       {&wire::ControlCounters::truncated, &wire::ControlCounters::bad_magic,
        &wire::ControlCounters::bad_version, &wire::ControlCounters::bad_length,
        &wire::ControlCounters::bad_crc, &wire::ControlCounters::bad_field,
        &wire::ControlCounters::not_control, &wire::ControlCounters::foreign,
        &wire::ControlCounters::too_short}) {
    std::uint64_t expected = 0;
    for (std::size_t kind = 0; kind < kinds.size(); ++kind) {
      expected += kinds[kind].counter == counter ? sent[kind] : 0;
    }
    EXPECT_EQ(counters.*counter, expected) << "seed " << kSeed;
  }
  EXPECT_EQ(counters.overrun, 0U);
  EXPECT_EQ(counters.busy, 0U);
  EXPECT_GE(renewals, 1);
  EXPECT_EQ(sensor.list().count, 1U);
}

// As fast as it can, from three threads; nothing is lost but what the socket cannot hold, and that
// is counted.
TEST(ControlFlood, AtFullSpeedLosesNothingUncounted) {
  if (!counts_overruns()) {
    GTEST_SKIP() << "this system does not count datagrams that find the buffer full";
  }
  Sensor sensor;
  ControlClient robot(sensor);
  ASSERT_EQ(robot.ask(), SubscribeResult::kOk);
  const wire::ControlCounters before = control_counters(sensor.handler, *sensor.port);
  const int each = long_or(1'000'000, 20'000);
  std::atomic<std::uint64_t> sent{0};
  const auto flood = [&] {
    ControlClient attacker(sensor);
    const Bytes datagram(60, std::byte{'x'});
    for (int i = 0; i < each; ++i) {
      sent += attacker.send_any(datagram) ? 1 : 0;
    }
  };
  std::thread second(flood);
  std::thread third(flood);
  flood();
  second.join();
  third.join();
  const auto told = [&] {
    const wire::ControlCounters now = control_counters(sensor.handler, *sensor.port);
    return now.bad_magic - before.bad_magic + now.overrun;
  };
  for (int i = 0; i < 2000 && told() < sent; ++i) {
    // Losses are told with what arrives next.
    static_cast<void>(robot.ask());
    std::this_thread::sleep_for(5ms);
  }
  // Keep-alives of ours may be among those lost.
  EXPECT_GE(told(), sent.load());
  EXPECT_LE(told(), sent.load() + 3);
  EXPECT_EQ(robot.ask(), SubscribeResult::kOk);
}

}  // namespace
}  // namespace stof::test
