#include "host/client/arrival_clock.h"

#include <chrono>

#include <gtest/gtest.h>

namespace stof::client {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;
using std::chrono::seconds;

// Two clocks that run alike, until somebody sets the wall clock.
struct Clocks {
  Duration elapsed{};
  nanoseconds set{};  // by how much the wall clock was set since the beginning

  ArrivalClock::Now now() const { return {Time(seconds(500) + elapsed), wall()}; }
  Time monotonic() const { return now().monotonic; }
  nanoseconds wall() const { return seconds(1'700'000'000) + elapsed + set; }
};

TEST(ArrivalClock, AStampIsWhenTheDatagramArrived) {
  Clocks clocks;
  ArrivalClock arrival(clocks.now());
  clocks.elapsed = seconds(1);
  const nanoseconds stamp = clocks.wall();
  const Time came = clocks.monotonic();
  clocks.elapsed = seconds(5);
  arrival.read(clocks.now());
  EXPECT_EQ(arrival.arrival(stamp), came);
}

// Set at any time around one datagram of each second, by more or less than the pause: nothing old
// is taken for new, and all is right again once the queue was empty.
TEST(ArrivalClock, AWallClockThatIsSetMakesNothingOldNew) {
  constexpr milliseconds kNear(11);
  for (const seconds set :
       {seconds(-100'000), seconds(-3), seconds(-1), seconds(1), seconds(3), seconds(100'000)}) {
    for (const milliseconds at : {milliseconds(0), milliseconds(1500), milliseconds(3999)}) {
      Clocks clocks;
      ArrivalClock arrival(clocks.now());
      std::vector<std::pair<nanoseconds, Time>> queue;
      for (; clocks.elapsed < seconds(4); clocks.elapsed += milliseconds(50)) {
        clocks.set = clocks.elapsed >= at ? nanoseconds(set) : nanoseconds(0);
        queue.emplace_back(clocks.wall(), clocks.monotonic());
      }
      arrival.read(clocks.now());
      Time before{};
      for (const auto& [stamp, came] : queue) {
        const Time told = arrival.arrival(stamp);
        EXPECT_LE(told, came + kNear) << set.count() << " s after " << at.count() << " ms";
        EXPECT_GE(told, before);
        before = told;
      }
      arrival.emptied(clocks.monotonic());
      clocks.elapsed += milliseconds(33);
      const nanoseconds stamp = clocks.wall();
      const Time came = clocks.monotonic();
      clocks.elapsed += milliseconds(2);
      arrival.read(clocks.now());
      EXPECT_EQ(arrival.arrival(stamp), came);
    }
  }
}

TEST(ArrivalClock, ANonsensicalStampIsAsOldAsItCanBe) {
  Clocks clocks;
  ArrivalClock arrival(clocks.now());
  const Time opened = clocks.monotonic();
  clocks.elapsed = seconds(2);
  arrival.read(clocks.now());
  EXPECT_EQ(arrival.arrival(nanoseconds(0)), opened);
  EXPECT_EQ(arrival.arrival(clocks.wall() + seconds(9)), opened);
}

}  // namespace
}  // namespace stof::client
