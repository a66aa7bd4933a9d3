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
  std::vector<Datagram> packets = parts(2, 2);
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

// Whoever is ahead makes the sensor's frames old.
TEST_F(ForgedFrame, FramesThatWerePassedOverAreTold) {
  for (const std::uint32_t lead : {3U, 8U, 120U, 128U}) {
    reassembler_ = Reassembler();
    push(parts(1, 1));
    for (std::uint32_t number = 2; number < 5; ++number) {
      EXPECT_EQ(reassembler_.forgeries(), 0U) << lead << " " << number;
      EXPECT_EQ(push(parts(number + lead, 77)), 1);
      EXPECT_EQ(push(parts(number, number)), 0);
    }
    EXPECT_GT(reassembler_.forgeries(), 0U) << lead;
  }
}

// Where the way of a packet takes up to six periods, frames lie in each other.
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

// Who sends parity where the sensor sends none fills the gap that the sensor is about to fill.
TEST_F(ForgedFrame, WhatForgedParityMakesIsTold) {
  push({parts(1, 1, true).back()});
  std::vector<Datagram> packets = parts(2, 2);
  const Datagram sent = packets[3];
  packets.erase(packets.begin() + 3);
  packets.push_back(parts(2, 2, true).back());
  EXPECT_EQ(push(packets), 1);  // its info had another number of parity's groups: pixels differ
  EXPECT_EQ(reassembler_.forgeries(), 0U);
  push({sent});
  EXPECT_GT(reassembler_.forgeries(), 0U);
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
