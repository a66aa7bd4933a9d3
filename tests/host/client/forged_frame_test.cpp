// Two senders of one frame: the network repeats packets exactly, so others are somebody else's.
#include <algorithm>
#include <chrono>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "host/client/reassembler.h"
#include "host/client/session/session_tracker.h"
#include "tests/host/client/sent_frame.h"

namespace stof::client {
namespace {

using std::chrono::milliseconds;
using test::Datagram;
using test::datagrams;
using test::frame_spec;
using test::FrameSpec;

constexpr Time kStart{std::chrono::seconds(100)};

class ForgedFrame : public testing::Test {
 protected:
  int push(const std::vector<Datagram>& packets) {
    int came = 0;
    for (const Datagram& packet : packets) {
      reassembler_.push(packet, now_);
      came += reassembler_.take(now_) ? 1 : 0;
    }
    now_ += milliseconds(33);
    return came;
  }
  static std::vector<Datagram> parts(std::uint32_t number, std::uint64_t seed,
                                     bool parity = false) {
    FrameSpec spec = frame_spec(number);
    spec.seed = seed;
    spec.parity = parity;
    return datagrams(spec);
  }

  Reassembler reassembler_;
  Time now_ = kStart;
};

TEST_F(ForgedFrame, WhatTheNetworkRepeatsIsNoForgery) {
  for (const bool parity : {false, true}) {
    reassembler_ = Reassembler();
    for (std::uint32_t number = 1; number < 5; ++number) {
      std::vector<Datagram> packets = parts(number, number, parity);
      packets.insert(packets.begin() + 3, packets[2]);
      EXPECT_EQ(push(packets), 1);
      EXPECT_EQ(push(packets), 0);
    }
    EXPECT_EQ(reassembler_.forgeries(), 0U) << parity;
    EXPECT_EQ(reassembler_.statistics().bad_field, 0U) << parity;
  }
}

TEST_F(ForgedFrame, AWholeOneBeforeTheSensorsIsTold) {
  for (const bool parity : {false, true}) {
    reassembler_ = Reassembler();
    EXPECT_EQ(push(parts(1, 1, parity)), 1);
    EXPECT_EQ(push(parts(2, 77, parity)), 1);  // somebody else's
    EXPECT_EQ(reassembler_.forgeries(), 0U) << parity;
    EXPECT_EQ(push(parts(2, 2, parity)), 0);
    EXPECT_GT(reassembler_.forgeries(), 0U) << parity;
  }
}

TEST_F(ForgedFrame, OnePacketOfItBeforeTheSensorsIsTold) {
  const std::vector<Datagram> packets = parts(2, 2);
  EXPECT_EQ(push({parts(2, 77)[1]}), 0);
  EXPECT_EQ(reassembler_.forgeries(), 0U);
  push(packets);
  EXPECT_GT(reassembler_.forgeries(), 0U);
}

TEST_F(ForgedFrame, OneOfAnotherExposureIsTold) {
  FrameSpec other = frame_spec(2);
  other.freshness = 3;
  EXPECT_EQ(push({datagrams(other).front()}), 0);
  push(parts(2, 2));
  EXPECT_GT(reassembler_.forgeries(), 0U);
}

// Whoever is ahead makes the sensor's frames old. A short lead is found when the sensor comes to
// his numbers, a long one when its frames were passed over for half a second.
TEST_F(ForgedFrame, FramesThatWerePassedOverAreTold) {
  for (const std::uint32_t lead : {3U, 8U, 16U, 120U, 128U}) {
    reassembler_ = Reassembler();
    push(parts(1, 1));
    const Time begin = now_;
    for (std::uint32_t number = 2; reassembler_.forgeries() == 0; ++number) {
      ASSERT_LT(now_ - begin, milliseconds(700)) << lead;
      push(parts(number + lead, 77));
      now_ -= milliseconds(33);
      push(parts(number, number));
    }
  }
}

// The sensor makes less than three frames a second.
TEST_F(ForgedFrame, FramesOfASlowSensorThatWerePassedOverAreTold) {
  for (const milliseconds period : {milliseconds(600), milliseconds(1000), milliseconds(3000)}) {
    for (const std::uint32_t lead : {20U, 100U}) {
      reassembler_ = Reassembler();
      push(parts(1, 1));
      const Time begin = now_;
      for (std::uint32_t number = 2; reassembler_.forgeries() == 0; ++number) {
        ASSERT_LE(now_ - begin, 4 * period + milliseconds(500)) << lead;
        now_ += period - milliseconds(33);
        push(parts(number + lead, 77));
        now_ -= milliseconds(33);
        push(parts(number, number));
      }
    }
  }
}

// He makes only each fourth number, so that he is further ahead with each frame.
TEST_F(ForgedFrame, FramesThatSomebodyCountsFasterAreTold) {
  push(parts(1, 1));
  const Time begin = now_;
  for (std::uint32_t number = 2; reassembler_.forgeries() == 0; ++number) {
    ASSERT_LT(now_ - begin, milliseconds(700));
    push(parts(4 * number, 77));
    now_ -= milliseconds(33);
    push(parts(number, number));
  }
}

// He begins each of the next numbers with parity alone, of which nothing is remembered.
TEST_F(ForgedFrame, NumbersThatParityAloneHasTakenAreTold) {
  push(parts(1, 1));
  for (std::uint32_t number = 2; number < 100; ++number) {
    push({parts(number, 77, true).back()});
    now_ -= milliseconds(33);
  }
  const Time begin = now_;
  for (std::uint32_t number = 2; reassembler_.forgeries() == 0; ++number) {
    ASSERT_LT(now_ - begin, milliseconds(700));
    push(parts(number + 98, 77));
    now_ -= milliseconds(33);
    push(parts(number, number));
  }
}

// A few packets a frame, 50 frames a second, each packet up to 250 ms on its way.
TEST_F(ForgedFrame, SmallFramesOfABadNetworkAreNoForgery) {
  std::mt19937 random(5);                  // NOLINT: the same order in each run
  std::multimap<unsigned, Datagram> sent;  // by when it comes, ms
  for (std::uint32_t number = 50; number < 1550; ++number) {
    std::vector<Datagram> packets = parts(number, number);
    for (std::size_t k = 0; k < 2; ++k) {
      sent.emplace(number * 20 + random() % 250, std::move(packets[k]));
    }
  }
  for (const auto& [at_ms, packet] : sent) {
    reassembler_.push(packet, kStart + milliseconds(at_ms), kStart + milliseconds(at_ms));
    static_cast<void>(reassembler_.take());
  }
  EXPECT_GT(reassembler_.statistics().late, 1000U);
  EXPECT_EQ(reassembler_.forgeries(), 0U);
}

// However far he is ahead, and whichever packet of a frame he makes.
TEST_F(ForgedFrame, FramesThatSomebodyGoesOnMakingAheadOfTheSensorAreTold) {
  for (const std::uint32_t lead : {2U, 3U, 8U, 60U}) {
    for (const bool whole : {true, false}) {
      reassembler_ = Reassembler();
      const auto made = [&](std::uint32_t number) {
        const std::vector<Datagram> all = parts(number, 1000 + number);
        return whole ? all : std::vector<Datagram>{all.back()};
      };
      push(parts(1, 1));
      for (std::uint32_t number = 2; number < 2 + lead; ++number) {
        push(made(number));
        now_ -= milliseconds(32);
      }
      ASSERT_EQ(reassembler_.forgeries(), 0U);
      for (std::uint32_t number = 2; number < 6; ++number) {
        push(parts(number, number));
        push(made(number + lead));
      }
      EXPECT_GT(reassembler_.forgeries(), 0U) << lead << whole;
    }
  }
}

TEST_F(ForgedFrame, WhatTheNetworkRepeatsLongAfterItsFrameIsNoForgery) {
  std::vector<std::vector<Datagram>> frames;
  for (std::uint32_t number = 1; number < 300; ++number) {
    frames.push_back(parts(number, number));
    EXPECT_EQ(push(frames.back()), 1);
  }
  for (std::size_t k = 60; k < 298; k += 12) {
    push({frames[k][k % frames[k].size()]});
  }
  EXPECT_EQ(reassembler_.forgeries(), 0U);
}

// Where the way of a packet takes up to six periods, frames lie in each other.
TEST_F(ForgedFrame, LatePacketsOfFramesThatBeganAreNoForgery) {
  std::mt19937 random(3);                  // NOLINT: the same order in each run
  std::multimap<unsigned, Datagram> sent;  // by when it comes, ms
  for (std::uint32_t number = 50; number < 350; ++number) {
    for (Datagram& packet : parts(number, number)) {
      sent.emplace(number * 33 + random() % 200, std::move(packet));
    }
  }
  for (const auto& [at_ms, packet] : sent) {
    reassembler_.push(packet, kStart + milliseconds(at_ms), kStart + milliseconds(at_ms));
    static_cast<void>(reassembler_.take());
  }
  EXPECT_GT(reassembler_.statistics().late, 1000U);
  EXPECT_EQ(reassembler_.forgeries(), 0U);
}

// What parity made good came in no datagram, so that the one that comes after all is none of two.
TEST_F(ForgedFrame, WhatComesAfterParityMadeItGoodIsNoForgery) {
  push(parts(1, 1, true));  // the sender uses it
  std::vector<Datagram> packets = parts(2, 2, true);
  const Datagram late = packets[2];
  packets.erase(packets.begin() + 2);
  EXPECT_EQ(push(packets), 1);
  EXPECT_EQ(reassembler_.statistics().recovered, 1U);
  EXPECT_EQ(push({late}), 0);
  EXPECT_EQ(reassembler_.forgeries(), 0U);
}

// Who makes the sensor's parity before it fills the gap that the sensor is about to fill.
TEST_F(ForgedFrame, WhatForgedParityMakesIsTold) {
  EXPECT_EQ(push(parts(1, 1, true)), 1);
  FrameSpec other = frame_spec(2);
  other.parity = true;
  other.settings = 9;  // in its info, so that what its parity makes differs
  std::vector<Datagram> packets = parts(2, 2, true);
  const Datagram sent = packets[3];
  packets.erase(packets.begin() + 3);
  packets.back() = datagrams(other).back();
  EXPECT_EQ(push(packets), 1);
  EXPECT_EQ(reassembler_.statistics().recovered, 1U);
  EXPECT_EQ(reassembler_.forgeries(), 0U);
  push({sent});
  EXPECT_GT(reassembler_.forgeries(), 0U);
}

// Who sends parity where the sensor sends none fills the gaps that the network left.
TEST_F(ForgedFrame, ParityOfAFrameThatHasNoneIsToldAndMakesNothing) {
  for (const bool first : {true, false}) {
    for (std::size_t k = 1; k < 4; ++k) {
      reassembler_ = Reassembler();
      EXPECT_EQ(push(parts(1, 1)), 1);
      std::vector<Datagram> packets = parts(2, 2);
      packets.erase(packets.begin() + 3);  // lost
      const Datagram forged = parts(2, 77, true).back();
      packets.insert(packets.begin() + (first ? 0 : static_cast<int>(k)), forged);
      EXPECT_EQ(push(packets), 0);
      EXPECT_EQ(push(parts(3, 3)), 1);
      EXPECT_EQ(reassembler_.statistics().recovered, 0U);
      EXPECT_GT(reassembler_.forgeries(), 0U) << first << k;
      const std::uint64_t before = reassembler_.forgeries();
      push({parts(3, 77, true).back()});  // of a frame that is over
      EXPECT_GT(reassembler_.forgeries(), before);
    }
  }
}

// Nor where the frame's info is lost: the newest one told of none.
TEST_F(ForgedFrame, ParityThatNoInfoTellsOfMakesNothing) {
  EXPECT_EQ(push(parts(1, 1, true)), 1);
  EXPECT_EQ(push(parts(2, 2)), 1);
  for (std::uint32_t number = 3; number < 10; ++number) {
    std::vector<Datagram> packets = parts(number, number);
    packets.erase(packets.begin());
    packets.push_back(parts(number, 77, true).back());
    push(packets);
  }
  EXPECT_EQ(reassembler_.statistics().recovered, 0U);
}

// Its clock stood, the sensor's counters did not.
TEST_F(ForgedFrame, AMachineThatSleepsTakesNothingForForged) {
  reassembler_.slept(std::chrono::hours(3));  // before this stream
  std::uint32_t number = 1;
  for (; number < 20; ++number) {
    EXPECT_EQ(push(parts(number, number)), 1);
  }
  for (Duration slept = std::chrono::hours(3); number < 1000; number += 300) {
    slept += milliseconds(300 * 33);
    reassembler_.slept(slept);
    EXPECT_EQ(push(parts(number, number)), 1) << number;
  }
  EXPECT_EQ(reassembler_.statistics().implausible, 0U);
  EXPECT_EQ(reassembler_.forgeries(), 0U);
}

// Whoever does not run for a while finds what came meanwhile in the socket.
TEST_F(ForgedFrame, WhatWaitedForAStoppedReceiverIsNoForgery) {
  for (const milliseconds stop : {milliseconds(500), milliseconds(1300), milliseconds(2500)}) {
    reassembler_ = Reassembler();
    now_ = kStart;
    std::uint32_t number = 1;
    for (; number < 30; ++number) {
      EXPECT_EQ(push(parts(number, number)), 1);
    }
    const Time runs_again = now_ + stop;
    int came = 0;
    for (; number < 200; ++number) {
      for (const Datagram& packet : parts(number, number)) {
        reassembler_.push(packet, now_, std::max(now_, runs_again));
        came += reassembler_.take(std::max(now_, runs_again)) ? 1 : 0;
      }
      now_ += milliseconds(33);
    }
    EXPECT_GT(came, 90) << stop.count();
    EXPECT_EQ(reassembler_.forgeries(), 0U) << stop.count();
  }
}

// Of a session that was never that sensor's: what says nothing of a sensor makes and keeps none.
TEST_F(ForgedFrame, WhatIsNoNewsOfASensorHoldsNoListener) {
  Datagram idle = test::calibration_datagram(frame_spec(1), 1);
  for (const unsigned type : {68U, 69U, 127U, 200U}) {
    reassembler_ = Reassembler();
    idle[5] = static_cast<std::byte>(type);
    test::reseal(idle);
    push({idle});
    FrameSpec spec = frame_spec(1);
    spec.origin.session_id = 9;
    EXPECT_EQ(push(datagrams(spec)), 1) << type;
  }
}

}  // namespace
}  // namespace stof::client
