#include <gtest/gtest.h>

#include "firmware/wire/bytes.h"
#include "host/client/reassembler.h"
#include "host/client/session/link_watch.h"
#include "tests/host/client/sent_frame.h"

// What somebody else says of a sensor's range and period, which settings change.
namespace stof::client {
namespace {

using std::chrono::milliseconds;
using test::FrameSpec;

constexpr Duration kPeriod = milliseconds(50);
constexpr std::uint32_t kRangeUm = 6'000'000;

class ForgedSettings : public ::testing::Test {
 protected:
  FrameSpec frame() const {
    FrameSpec spec = test::frame_spec(number_);
    spec.calibration = 77;
    spec.settings = settings_;
    spec.max_range_um = range_um_;
    spec.period_ns = std::chrono::nanoseconds(period_).count();
    return spec;
  }
  void send(const std::vector<test::Datagram>& packets) {
    for (const test::Datagram& packet : packets) {
      reassembler_.push(packet, now_);
    }
    watch_.look(reassembler_, now_);
  }
  void say(const FrameSpec& spec) { send({test::calibration_datagram(spec, spec.period_ns)}); }

  // So many frames, a message beside every tenth; forge(spec) comes behind each.
  template <typename Forge>
  void stream(int frames, Forge forge) {
    for (int k = 0; k < frames; ++k) {
      now_ += period_;
      ++number_;
      const FrameSpec spec = frame();
      if (changed_ || number_ % 10 == 0) {
        say(spec);
        changed_ = false;
      }
      send(test::datagrams(spec));
      while (const std::optional<Frame> taken = reassembler_.take(now_)) {
        watch_.delivered(*taken);
        ASSERT_TRUE(taken->calibration) << number_;
        true_ += taken->calibration->max_range == range_um_ / test::kDepthUnitUm &&
                         taken->calibration->period_ns == spec.period_ns
                     ? 1
                     : 0;
      }
      forge(spec);
    }
  }
  void stream(int frames) {
    stream(frames, [](const FrameSpec&) {});
  }
  void set(std::uint32_t range_um, Duration period) {
    ++settings_;
    range_um_ = range_um;
    period_ = period;
    changed_ = true;
  }
  bool told() const { return watch_.state(now_).forged_traffic; }

  Reassembler reassembler_;
  Time now_{std::chrono::seconds(100)};
  LinkWatch watch_{now_};
  std::uint32_t number_ = 1000;
  std::uint32_t settings_ = 1;
  std::uint32_t range_um_ = kRangeUm;
  Duration period_ = kPeriod;
  bool changed_ = true;
  int true_ = 0;
};

TEST_F(ForgedSettings, OfMessagesAreThoseOfNoFrameAndTold) {
  stream(40);
  ASSERT_FALSE(told());
  for (const std::uint32_t ahead : {0U, 1U, 100U}) {
    SCOPED_TRACE(ahead);
    true_ = 0;
    stream(120, [&](FrameSpec spec) {
      spec.number += ahead;
      spec.max_range_um = 500'000;
      spec.period_ns = 50 * spec.period_ns;
      say(spec);
    });
    EXPECT_EQ(true_, 120);
    EXPECT_TRUE(told());
    EXPECT_EQ(reassembler_.period(), kPeriod);
    EXPECT_EQ(reassembler_.calibration()->max_range, kRangeUm / test::kDepthUnitUm);
    stream(100);
  }
}

// As was found: behind each of the sensor's own, while its owner changes something else.
TEST_F(ForgedSettings, BesideAnOwnerWhoChangesSomethingElseAreToldToo) {
  stream(40);
  true_ = 0;
  for (int change = 0; change < 20; ++change) {
    set(kRangeUm, kPeriod);
    stream(16, [&](FrameSpec spec) {
      if (spec.number % 5 == 0) {
        spec.max_range_um = 500'000;
        say(spec);
      }
    });
  }
  EXPECT_EQ(true_, 20 * 16);
  EXPECT_TRUE(told());
}

TEST_F(ForgedSettings, OfAnotherFileAreTold) {
  stream(40);
  stream(20, [&](FrameSpec spec) {
    spec.calibration = 99;
    say(spec);
  });
  EXPECT_TRUE(told());
  EXPECT_EQ(true_, 60);
}

// An owner with a slider, and a network that brings messages before or behind everything.
TEST_F(ForgedSettings, ThatChangeWithEveryFrameAreNoForgery) {
  std::vector<FrameSpec> held;
  for (int k = 0; k < 400; ++k) {
    set(kRangeUm + static_cast<std::uint32_t>(k) * 1000, milliseconds(33 + k % 40));
    now_ += period_;
    ++number_;
    held.push_back(frame());
    const bool early = k % 3 == 0;
    if (early) {
      say(held.back());
    }
    send(test::datagrams(held.back()));
    while (reassembler_.take(now_)) {
    }
    if (k % 7 == 6) {
      for (const FrameSpec& late : held) {
        say(late);
      }
      held.clear();
    }
  }
  EXPECT_FALSE(told());
}

TEST_F(ForgedSettings, WhoseFrameLostItsInfoAreThoseOfTheFrameBefore) {
  stream(20);
  now_ += kPeriod;
  ++number_;
  FrameSpec lie = frame();
  lie.max_range_um = 500'000;
  say(lie);
  std::vector<test::Datagram> packets = test::datagrams(frame());
  std::erase_if(packets, [](const test::Datagram& packet) {
    return wire::parse_packet(packet)->header.type == wire::PacketType::kFrameInfo;
  });
  send(packets);
  reassembler_.expire(*reassembler_.next_expiry());
  const std::optional<Frame> taken = reassembler_.take();
  ASSERT_TRUE(taken);
  ASSERT_FALSE(taken->info);
  ASSERT_TRUE(taken->calibration);
  EXPECT_EQ(taken->calibration->max_range, kRangeUm / test::kDepthUnitUm);
}

// A silent sensor is silent by the period of its frames.
TEST_F(ForgedSettings, PutOffNoAlarmForSilence) {
  stream(60, [&](FrameSpec spec) {
    spec.period_ns = 60'000'000'000;
    say(spec);
  });
  EXPECT_FALSE(watch_.state(now_ + 3 * kPeriod).silent);
  EXPECT_TRUE(watch_.state(now_ + 3 * kPeriod + milliseconds(21)).silent);
}

// Messages alone speak before the first frame does; then what they said is forgotten.
TEST_F(ForgedSettings, FromTheStartMakeNoFalseAlarmForSilence) {
  period_ = milliseconds(600);
  for (int k = 0; k < 10; ++k) {
    FrameSpec lie = frame();
    lie.number += 100;
    lie.period_ns = 20'000'000;
    say(lie);
  }
  stream(12, [&](FrameSpec spec) {
    spec.number += 100;
    spec.period_ns = 20'000'000;
    say(spec);
    watch_.look(reassembler_, now_);
    EXPECT_FALSE(watch_.state(now_ + period_).silent);
  });
}

TEST_F(ForgedSettings, OfAnOlderSensorComeWithItsMessages) {
  for (int k = 0; k < 20; ++k) {
    now_ += kPeriod;
    ++number_;
    FrameSpec spec = frame();
    say(spec);
    spec.max_range_um = 0;
    spec.period_ns = 0;
    std::vector<test::Datagram> packets = test::datagrams(spec);
    for (test::Datagram& packet : packets) {
      if (wire::parse_packet(packet)->header.type == wire::PacketType::kFrameInfo) {
        packet.erase(packet.end() - 4 - 12, packet.end() - 4);
        wire::put_u16(std::span(packet).subspan<50, 2>(), wire::kFrameInfoBytes - 12);
        test::reseal(packet);
      }
    }
    send(packets);
    const std::optional<Frame> taken = reassembler_.take(now_);
    ASSERT_TRUE(taken && taken->calibration && taken->info);
    EXPECT_EQ(taken->info->settings_revision, settings_);
    EXPECT_EQ(taken->calibration->max_range, kRangeUm / test::kDepthUnitUm);
    EXPECT_EQ(taken->calibration->period_ns, spec.period_ns == 0 ? 50'000'000 : 0);
  }
  EXPECT_FALSE(told());
}

}  // namespace
}  // namespace stof::client
