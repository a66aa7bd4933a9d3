#include "host/client/session/clock_map.h"

#include <chrono>
#include <cstdint>
#include <limits>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

using namespace std::chrono_literals;

constexpr Time kStart{1000s};
constexpr std::int64_t kAhead = 123'456'789;  // this machine's clock less the sensor's, ns

// Exposed `at` by this machine's clock, sent 20 ms later, `way` under way.
Frame frame(Time at, Duration way, std::int64_t ahead_ns = kAhead, std::uint32_t session = 1) {
  Frame out;
  out.origin.session_id = session;
  out.stamp.exposure_middle_ns = at.time_since_epoch().count() - ahead_ns;
  out.info.emplace();
  out.info->latency_ns = 20'000'000;
  out.first_packet = at + 20ms + way;
  return out;
}

TEST(ClockMap, IsThatOfTheQuickestWay) {
  ClockMap map;
  EXPECT_FALSE(map.mapping());
  map.add(frame(kStart, 5ms));
  map.add(frame(kStart + 33ms, 300us));
  map.add(frame(kStart + 66ms, 8ms));
  ASSERT_TRUE(map.mapping());
  EXPECT_EQ(map.mapping()->offset_ns, kAhead + 300'000);
  EXPECT_EQ(map.mapping()->spread_ns, 7'700'000);
  EXPECT_EQ(map.mapping()->newest, kStart + 94ms);
}

// A clock that runs 200 ppm slow or fast: the offset is never more than a window's drift away.
TEST(ClockMap, FollowsClocksThatDrift) {
  for (const int ppm : {-200, 200}) {
    ClockMap map;
    for (int i = 0; i < 1000; ++i) {
      const Duration since = 33ms * i;
      const std::int64_t ahead = kAhead + since.count() / 1'000'000 * ppm;
      map.add(frame(kStart + since, i % 7 == 0 ? Duration(100us) : Duration(4ms), ahead));
      ASSERT_TRUE(map.mapping());
      const std::int64_t off = map.mapping()->offset_ns - ahead;
      ASSERT_LE(off, 4'000'000 + 400'000) << i;
      ASSERT_GE(off, 100'000 - 900'000) << i;
      if (i > 10) {
        ASSERT_LE(off, 100'000 + 900'000) << i;
      }
    }
  }
}

TEST(ClockMap, ForgetsWhatWasLongBefore) {
  ClockMap map;
  map.add(frame(kStart, 100us, kAhead - 50'000'000));
  map.add(frame(kStart + 1h, 100us));
  EXPECT_EQ(map.mapping()->offset_ns, kAhead + 100'000);
  EXPECT_EQ(map.mapping()->spread_ns, 0);
}

TEST(ClockMap, ARestartBeginsAnew) {
  ClockMap map;
  map.add(frame(kStart, 100us));
  map.add(frame(kStart + 33ms, 200us, -kAhead, 2));
  EXPECT_EQ(map.mapping()->offset_ns, -kAhead + 200'000);
  Frame silent = frame(kStart + 66ms, 0ms, 0, 3);
  silent.info.reset();  // did not arrive
  map.add(silent);
  EXPECT_FALSE(map.mapping());
}

TEST(ClockMap, EmulatedAndRecordedTimeIsMappedToNone) {
  for (const auto clock : {wire::ClockState::kEmulated, wire::ClockState::kRecorded}) {
    ClockMap map;
    Frame one = frame(kStart, 100us);
    one.stamp.clock = clock;
    map.add(one);
    EXPECT_FALSE(map.mapping());
    EXPECT_TRUE(map.unmappable());
    map.add(frame(kStart, 100us));
    EXPECT_FALSE(map.unmappable());
  }
}

// Stamps are bytes from the network: the sanitizers watch.
TEST(ClockMap, AnyStampMayCome) {
  ClockMap map;
  for (const std::int64_t stamp : {std::numeric_limits<std::int64_t>::min(),
                                   std::numeric_limits<std::int64_t>::max(), std::int64_t{0}}) {
    for (const std::int64_t latency :
         {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max(),
          std::int64_t{-1}}) {
      Frame one = frame(kStart, 1ms);
      one.stamp.exposure_middle_ns = stamp;
      one.info->latency_ns = latency;
      map.add(one);
      EXPECT_TRUE(map.mapping());
    }
  }
}

}  // namespace
}  // namespace stof::client
