#include "firmware/pipeline/raw_sender.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include <gtest/gtest.h>

#include "hal/emu/devices/clock.h"
#include "tests/support/random.h"

namespace stof::firmware {
namespace {

using namespace std::chrono_literals;
namespace emu = hal::emu;

constexpr int kWidth = 160;
constexpr int kHeight = 120;
constexpr hal::Duration kPeriod = 33ms;

class Slots final : public hal::SlotOwner {
 public:
  void give_back(int /*slot*/) noexcept override { --lent; }
  int lent = 0;
};

// Takes what a test allows.
class Link final : public RawSender::Way {
 public:
  explicit Link(emu::Clock& clock) : clock_(clock) {}
  Status send_raw(wire::Datagrams datagrams, std::size_t& sent) noexcept override {
    longest = std::max(longest, datagrams.size());
    asked.push_back(clock_.now());
    for (sent = 0; sent < datagrams.size() && room > 0; ++sent, --room) {
      packets.emplace_back(datagrams[sent].begin(), datagrams[sent].end());
      times.push_back(clock_.now());
    }
    return sent == datagrams.size() ? Status::kOk : refusal;
  }
  wire::PacketView packet(std::size_t i) const { return wire::parse_packet(packets.at(i)).value(); }
  wire::RawInfo info() const { return wire::decode_raw_info(packet(0).payload).value(); }
  void forget() {
    packets.clear();
    times.clear();
  }

  int room = 1 << 20;
  Status refusal = Status::kWouldBlock;
  std::size_t longest = 0;
  std::vector<std::vector<std::byte>> packets;
  std::vector<hal::Time> times;
  std::vector<hal::Time> asked;

 private:
  emu::Clock& clock_;
};

class RawSenderTest : public testing::Test {
 protected:
  RawSenderTest() {
    test::Random random(5);
    for (std::uint8_t& pixel : left_) {
      pixel = static_cast<std::uint8_t>(random.between(0, 255));
    }
    for (std::uint16_t& sample : samples_) {
      sample = static_cast<std::uint16_t>(random.between(0, 4095));
    }
    sender_.set_period(kPeriod);
  }
  // As a camera lends it; the frame that was made of it has the next number.
  void offer(bool pair = true, bool pmd = true, std::uint8_t state = 0) {
    Shot shot{.edge = clock_.now() - 20ms,
              .exposed = {},
              .stereo = {},
              .pmd = {},
              .pmd_exposed = {},
              .freshness = ++stamp_.freshness,
              .state = state};
    ++stamp_.number;
    if (pair) {
      ++slots_.lent;
      shot.stereo.emplace(hal::StereoFrame{.left = {left_.data(), kWidth, kHeight},
                                           .right = {left_.data(), kWidth, kHeight},
                                           .left_exposure = {hal::Time{1s}, hal::Time{2s}},
                                           .right_exposure = {hal::Time{3s}, hal::Time{4s}},
                                           .left_sequence = 10,
                                           .right_sequence = 11},
                          slots_, 0);
    }
    if (pmd) {
      ++slots_.lent;
      const dsp::ImageView<const std::uint16_t> sample(samples_.data(), 16, 12);
      shot.pmd.emplace(hal::PmdFrame{.samples = {sample, sample, sample, sample},
                                     .exposures = {{{hal::Time{5s}, hal::Time{6s}}, {}, {}, {}}},
                                     .sequence = 12},
                       slots_, 1);
    }
    sender_.offer(shot, stamp_);
  }
  void send(hal::Duration time) { sender_.send_until(clock_.now() + time, link_); }
  // All of one exposure's packets are there.
  std::size_t whole() const { return link_.packets.empty() ? 0 : link_.packet(0).header.count; }

  emu::Clock clock_;
  Slots slots_;
  Link link_{clock_};
  RawSender sender_{{.device_id = 7, .session_id = 9}, clock_};
  wire::FrameStamp stamp_{.number = 100, .freshness = 200};
  std::vector<std::uint8_t> left_ = std::vector<std::uint8_t>(kWidth * kHeight);
  std::vector<std::uint16_t> samples_ = std::vector<std::uint16_t>(16 * 12);
};

constexpr wire::RawRequest kAll{.pictures = wire::kRawPictures};

TEST_F(RawSenderTest, NobodyAskedNothingIsKept) {
  offer();
  EXPECT_EQ(slots_.lent, 0);
  send(30ms);
  EXPECT_TRUE(link_.packets.empty());
}

TEST_F(RawSenderTest, TheSlotsGoHomeAfterTheLastPacket) {
  sender_.ask(kAll);
  const hal::Time begin = clock_.now();
  offer();
  EXPECT_EQ(slots_.lent, 2);
  send(10ms);
  EXPECT_EQ(slots_.lent, 2);
  EXPECT_LT(link_.packets.size(), whole());
  send(30ms);
  ASSERT_EQ(link_.packets.size(), whole());
  EXPECT_EQ(slots_.lent, 0);
  const wire::RawInfo info = link_.info();
  EXPECT_EQ(info.edge_ns, (begin - 20ms).time_since_epoch().count());
  EXPECT_EQ(info.pair_exposures[0].begin_ns, 1'000'000'000);
  EXPECT_EQ(info.pair_exposures[1].end_ns, 4'000'000'000);
  EXPECT_EQ(info.pmd_exposures[0].end_ns, 6'000'000'000);
  EXPECT_EQ(info.sequences, (std::array<std::uint32_t, 3>{10, 11, 12}));
  EXPECT_EQ(info.number, 1U);
  EXPECT_EQ(link_.packet(0).header.frame.freshness, 201U);
  EXPECT_EQ(link_.packet(0).header.frame.number, 101U);
  std::vector<std::byte> left;
  for (std::size_t i = 1; left.size() < left_.size(); ++i) {
    const wire::PacketView tile = link_.packet(i);
    ASSERT_EQ(tile.header.stream, wire::Stream::kRawLeft);
    left.insert(left.end(), tile.payload.begin(), tile.payload.end());
  }
  EXPECT_TRUE(std::ranges::equal(left, std::as_bytes(std::span(left_))));
}

TEST_F(RawSenderTest, TellsWhatHappenedSinceTheExposureBefore) {
  sender_.ask({.pictures = wire::kRawPictures, .every = 3});
  std::vector<int> told;
  for (const int state : {1, 0, 2, 0, 2, 1, 0}) {
    link_.forget();
    offer(true, true, static_cast<std::uint8_t>(state));
    send(1s);
    if (!link_.packets.empty()) {
      told.push_back(link_.info().state);
    }
  }
  EXPECT_EQ(told, (std::vector{1, 2, 3})) << "also of the exposures between, which are not sent";
}

// Else two frames that follow each other sooner than usual cost one of them.
TEST_F(RawSenderTest, SendsTheRestAtOnceWhereTheNextIsDue) {
  sender_.ask(kAll);
  offer();
  send(2ms);
  ASSERT_LT(link_.packets.size(), whole());
  sender_.hurry(clock_.now() + 20ms, link_);
  EXPECT_EQ(link_.packets.size(), whole());
  offer();
  EXPECT_EQ(sender_.dropped(), 0U);
  // Nobody waits for what is not due.
  link_.forget();
  sender_.ask({.pictures = wire::kRawPictures, .every = 9});
  offer();
  const hal::Time now = clock_.now();
  sender_.hurry(now + 20ms, link_);
  EXPECT_EQ(clock_.now(), now);
}

// What a frame waits for comes in time.
TEST_F(RawSenderTest, ReturnsBeforeTheTimeThatItIsGiven) {
  sender_.ask(kAll);
  offer();
  for (int us = 0; us < 400; us += 7) {
    const hal::Time until = clock_.now() + std::chrono::microseconds(us);
    const std::size_t before = link_.packets.size();
    sender_.send_until(until, link_);
    EXPECT_LE(clock_.now(), until);
    for (std::size_t i = before; i < link_.times.size(); ++i) {
      EXPECT_LE(link_.times[i] + RawSender::kMargin, until);
    }
    clock_.wait_until(until);
  }
  EXPECT_FALSE(link_.packets.empty());
  EXPECT_LE(link_.longest, RawSender::kBurst);
}

TEST_F(RawSenderTest, IsSpreadOverTheTimeUpToTheNextThatIsDue) {
  for (const std::uint16_t every : {std::uint16_t{1}, std::uint16_t{4}}) {
    link_.forget();
    sender_.ask({.pictures = wire::kRawPictures, .every = every});
    const hal::Time begin = clock_.now();
    offer();
    send(1s);
    ASSERT_EQ(link_.packets.size(), whole());
    const hal::Duration took = link_.times.back() - begin;
    EXPECT_LE(took, every * kPeriod * 3 / 4);
    EXPECT_GE(took, every * kPeriod / 2);
    for (std::size_t i = RawSender::kBurst; i < link_.times.size(); ++i) {
      EXPECT_GE(link_.times[i] - link_.times[i - RawSender::kBurst], RawSender::kGap);
    }
  }
}

TEST_F(RawSenderTest, OneExposureOfSoManyFramesIsSent) {
  sender_.ask({.pictures = wire::kRawPictures, .every = 3});
  std::vector<std::uint32_t> ids;
  for (int frame = 0; frame < 10; ++frame) {
    offer();
    send(200ms);
    if (!link_.packets.empty()) {
      ids.push_back(link_.packet(0).header.frame.freshness);
      link_.forget();
    }
  }
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{201, 204, 207, 210}));
  EXPECT_EQ(sender_.dropped(), 0U);
}

// With a slow PMD camera most frames have no samples of their own.
TEST_F(RawSenderTest, AnExposureCountsOnlyWithAllThatIsAskedForWhereThatIsAskedFor) {
  for (const bool all : {false, true}) {
    sender_.ask(
        {.pictures = static_cast<std::uint8_t>(wire::kRawPictures | (all ? wire::kRawWhole : 0))});
    for (const bool pmd : {false, true}) {
      link_.forget();
      offer(true, pmd);
      send(200ms);
      ASSERT_EQ(link_.packets.empty(), all && !pmd);
      if (!link_.packets.empty()) {
        EXPECT_EQ(link_.info().pictures,
                  pmd ? wire::kRawPictures : wire::kRawLeft | wire::kRawRight);
      }
      EXPECT_EQ(slots_.lent, 0);
    }
  }
  EXPECT_EQ(sender_.dropped(), 0U);
}

TEST_F(RawSenderTest, OnlyTheSlotOfWhatIsAskedForIsKept) {
  sender_.ask({.pictures = wire::kRawPmd});
  offer();
  EXPECT_EQ(slots_.lent, 1);
  send(200ms);
  EXPECT_EQ(link_.info().pictures, wire::kRawPmd);
  EXPECT_EQ(link_.info().camera_width, 0);
  link_.forget();
  offer(true, false);
  EXPECT_EQ(slots_.lent, 0);
  send(200ms);
  EXPECT_TRUE(link_.packets.empty());
}

TEST_F(RawSenderTest, WhatIsDueWhileAnotherIsOnItsWayIsDroppedAndToldWithTheNext) {
  sender_.ask(kAll);
  link_.room = 9;  // of a slow link: a frame's time
  offer();
  for (int frame = 0; frame < 3; ++frame) {
    send(kPeriod);
    offer();
  }
  EXPECT_EQ(sender_.dropped(), 3U);
  EXPECT_EQ(slots_.lent, 2) << "no more than one exposure's";
  EXPECT_EQ(link_.packets.size(), 9U);
  link_.room = 1 << 20;
  send(200ms);
  EXPECT_EQ(link_.packets.size(), whole()) << "nothing twice, nothing left out";
  for (std::size_t i = 0; i < link_.packets.size(); ++i) {
    EXPECT_EQ(link_.packet(i).header.index, i);
    EXPECT_EQ(link_.packet(i).header.frame.freshness, 201U);
  }
  link_.forget();
  offer();
  send(200ms);
  EXPECT_EQ(link_.info().number, 2U);
  EXPECT_EQ(link_.info().dropped, 3U);
}

TEST_F(RawSenderTest, IsGivenUpAfterASecondAlsoWhereThereIsNeverTime) {
  for (const bool busy : {false, true}) {
    sender_.ask(kAll);
    link_.room = 5;
    offer();
    for (int i = 0; i < 40 && slots_.lent > 0; ++i) {
      sender_.send_until(clock_.now() + (busy ? 0ms : 20ms), link_);
      EXPECT_EQ(sender_.dropped(), slots_.lent > 0 ? 0U : 1U);
      clock_.wait_until(clock_.now() + kPeriod);
    }
    EXPECT_EQ(slots_.lent, 0);
    EXPECT_EQ(sender_.dropped(), 1U);
  }
}

TEST_F(RawSenderTest, AQueueThatTakesNothingIsAskedLessAndLess) {
  sender_.ask({.pictures = wire::kRawPictures, .every = 30});
  link_.room = 0;
  offer();
  const hal::Time begin = clock_.now();
  send(900ms);
  EXPECT_LE(link_.asked.size(), 65U);  // each 16 ms
  EXPECT_GE(link_.asked.size(), 55U);
  EXPECT_LE(link_.asked.at(1), begin + RawSender::kRetry);
  link_.asked.clear();
  for (int i = 0; i < 3; ++i) {  // a slow link's: some of each burst, so at once again
    link_.room = 3;
    send(17ms);
  }
  EXPECT_EQ(link_.packets.size(), 9U);
  link_.room = 1 << 20;
  send(50ms);
  EXPECT_EQ(link_.packets.size(), whole());
}

TEST_F(RawSenderTest, AReceiverThatCannotBeReachedGetsNoMoreOfIt) {
  sender_.ask(kAll);
  link_.room = 5;
  link_.refusal = Status::kDeviceError;
  offer();
  send(200ms);
  EXPECT_EQ(slots_.lent, 0);
  EXPECT_EQ(sender_.dropped(), 1U);
  EXPECT_EQ(link_.packets.size(), 5U);
}

TEST_F(RawSenderTest, ACameraThatIsToBeOpenedAgainGetsItsSlotsBack) {
  sender_.ask(kAll);
  offer();
  send(5ms);
  sender_.give_back(false, true);
  EXPECT_EQ(slots_.lent, 0) << "the pictures of an exposure go together";
  EXPECT_EQ(sender_.dropped(), 1U);
  sender_.give_back(true, true);
  EXPECT_EQ(sender_.dropped(), 1U) << "there was nothing";
  link_.forget();
  offer();
  send(200ms);
  EXPECT_EQ(link_.packets.size(), whole());
}

// A camera that is gone takes nothing of the other one's pictures with it.
TEST_F(RawSenderTest, PicturesOfTheOtherCameraGoOn) {
  sender_.ask(kAll);
  for (const bool pair : {true, false}) {
    link_.forget();
    offer(pair, !pair);
    send(1ms);
    sender_.give_back(!pair, pair);
    send(200ms);
    ASSERT_GT(link_.packets.size(), 1U);
    EXPECT_EQ(link_.packets.size(), whole());
    EXPECT_EQ(link_.info().pictures, pair ? wire::kRawLeft | wire::kRawRight : wire::kRawPmd);
    EXPECT_EQ(slots_.lent, 0);
  }
  EXPECT_EQ(sender_.dropped(), 0U);
}

TEST_F(RawSenderTest, WhatIsGivenUpBeforeItsFirstPacketCountsOnceAndHidesNothing) {
  sender_.ask(kAll);
  offer(true, true, wire::kRawBegunAnew);
  sender_.give_back(true, true);
  EXPECT_EQ(sender_.dropped(), 1U);
  offer();
  send(200ms);
  EXPECT_EQ(link_.info().number, 1U);
  EXPECT_EQ(link_.info().dropped, 1U);
  EXPECT_EQ(link_.info().state, wire::kRawBegunAnew);
}

TEST_F(RawSenderTest, AnotherRequestBeginsAnewAndNoneEndsIt) {
  sender_.ask({.pictures = wire::kRawPictures, .every = 100});
  offer();
  send(5ms);
  sender_.ask(kAll);
  EXPECT_EQ(slots_.lent, 0);
  link_.forget();
  offer();
  send(200ms);
  EXPECT_EQ(link_.info().number, 1U);
  EXPECT_EQ(link_.info().dropped, 0U);
  sender_.ask({});
  link_.forget();
  offer();
  send(200ms);
  EXPECT_TRUE(link_.packets.empty());
  EXPECT_EQ(slots_.lent, 0);
}

}  // namespace
}  // namespace stof::firmware
