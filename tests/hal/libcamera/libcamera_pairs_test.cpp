#include "hal/linux/libcamera/libcamera_pairs.h"

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "hal/linux/libcamera/libcamera_buffer_queue.h"
#include "hal/linux/libcamera/libcamera_find.h"
#include "hal/linux/libcamera/libcamera_stereo.h"

namespace stof::test {
namespace {

using hal::Duration;
using hal::Time;
using hal::linux::EdgeExposures;
using hal::linux::EdgeLog;
using hal::linux::find_libcamera;
using hal::linux::from_libcamera;
using hal::linux::kLeft;
using hal::linux::kRight;
using hal::linux::LibcameraBufferQueue;
using hal::linux::LibcameraName;
using hal::linux::LibcameraPairs;
using std::chrono::milliseconds;

constexpr Duration kPeriod = milliseconds(33);
constexpr Duration kExposed = milliseconds(4);
constexpr Duration kTransfer = milliseconds(9);

Time edge(int n) { return Time(std::chrono::seconds(100)) + n * kPeriod; }

// Two cameras with buffers, as libcamera runs them: each fills the buffer that was queued first.
class Cameras : public hal::linux::LibcameraRequeuer {
 public:
  Cameras(int slots, int reserve) {
    for (const std::size_t side : {kLeft, kRight}) {
      pairs_.queue(side).reset(slots, reserve);
      queued_[side].clear();
      for (int slot = 0; slot < slots; ++slot) {
        queued_[side].push_back(slot);
      }
    }
    shoot(0);  // the first pictures, which are not believed
    EXPECT_FALSE(pairs_.next());
  }

  void requeue(std::size_t side, int slot) noexcept override { queued_[side].push_back(slot); }

  void trigger(int n) { edges_.note(edge(n)); }
  // The frame of edge n; lost where the camera has no buffer.
  void fill(std::size_t side, int n, Duration late = {}, bool damaged = false) {
    if (queued_[side].empty()) {
      return;
    }
    const int slot = queued_[side].front();
    queued_[side].erase(queued_[side].begin());
    const std::optional<int> back =
        pairs_.queue(side).deliver(slot, {.stamp = edge(n) + kExposed + kTransfer + late,
                                          .sequence = static_cast<std::uint32_t>(n),
                                          .damaged = damaged});
    if (back) {
      requeue(side, *back);
    }
  }
  void shoot(int n) {
    trigger(n);
    fill(kLeft, n);
    fill(kRight, n);
  }

  LibcameraPairs& pairs() { return pairs_; }
  std::size_t queued(std::size_t side) const { return queued_[side].size(); }

 private:
  EdgeLog edges_;
  EdgeExposures exposures_{edges_, kExposed};
  LibcameraPairs pairs_{{.exposure = kExposed,
                         .exposures = &exposures_,
                         .most_delay = milliseconds(25),
                         .most_skew = milliseconds(1)},
                        *this};
  std::array<std::vector<int>, 2> queued_;
};

// Both sequences of the next pair; none: there is no pair.
std::optional<std::pair<std::uint32_t, std::uint32_t>> numbers(Cameras& cameras) {
  const Result<LibcameraPairs::Pair> pair = cameras.pairs().next();
  if (!pair) {
    EXPECT_EQ(pair.error(), Status::kWouldBlock);
    return std::nullopt;
  }
  cameras.pairs().give_back(pair->number);
  return std::pair(pair->frames[kLeft].sequence, pair->frames[kRight].sequence);
}

std::pair<std::uint32_t, std::uint32_t> both(std::uint32_t n) { return {n, n}; }

TEST(LibcameraPairs, FramesOfOneExposureAreAPair) {
  Cameras cameras(6, 2);
  cameras.shoot(1);
  const Result<LibcameraPairs::Pair> pair = cameras.pairs().next();
  ASSERT_TRUE(pair);
  for (const std::size_t side : {kLeft, kRight}) {
    EXPECT_EQ(pair->frames[side].exposure.begin, edge(1));
    EXPECT_EQ(pair->frames[side].exposure.end, edge(1) + kExposed);
    EXPECT_EQ(cameras.queued(side), 5U);
  }
  cameras.pairs().give_back(pair->number);
  EXPECT_EQ(cameras.queued(kLeft), 6U);
  EXPECT_EQ(cameras.queued(kRight), 6U);
}

TEST(LibcameraPairs, PartnerOfALostFrameIsDropped) {
  for (const std::size_t lost : {kLeft, kRight}) {
    Cameras cameras(4, 1);
    cameras.shoot(1);
    EXPECT_EQ(numbers(cameras), both(1));
    cameras.trigger(2);
    cameras.fill(1 - lost, 2);
    EXPECT_EQ(numbers(cameras), std::nullopt);
    cameras.shoot(3);
    EXPECT_EQ(numbers(cameras), both(3));
    EXPECT_EQ(cameras.queued(kLeft), 4U);
    EXPECT_EQ(cameras.queued(kRight), 4U);
  }
}

TEST(LibcameraPairs, FrameThatArrivesLaterThanItsPartnerIsWaitedFor) {
  Cameras cameras(4, 1);
  cameras.trigger(1);
  cameras.fill(kLeft, 1);
  EXPECT_EQ(numbers(cameras), std::nullopt);
  cameras.fill(kRight, 1, milliseconds(5));
  EXPECT_EQ(numbers(cameras), both(1));
}

TEST(LibcameraPairs, FrameBeyondTheMostDelayBelongsToNothing) {
  Cameras cameras(4, 1);
  cameras.trigger(1);
  cameras.fill(kLeft, 1, milliseconds(17));
  cameras.fill(kRight, 1);
  EXPECT_EQ(numbers(cameras), std::nullopt);
  EXPECT_EQ(cameras.queued(kLeft), 4U);
  cameras.shoot(2);
  EXPECT_EQ(numbers(cameras), both(2));
}

TEST(LibcameraPairs, FrameWithoutAnEdgeIsDropped) {
  Cameras cameras(4, 1);
  cameras.fill(kLeft, 1);
  cameras.fill(kRight, 1);
  EXPECT_EQ(numbers(cameras), std::nullopt);
  EXPECT_EQ(cameras.queued(kLeft), 4U);
  EXPECT_EQ(cameras.queued(kRight), 4U);
}

TEST(LibcameraPairs, DamagedFrameIsToldOfOnce) {
  for (const std::size_t damaged : {kLeft, kRight}) {
    Cameras cameras(4, 1);
    cameras.trigger(1);
    cameras.fill(damaged, 1, {}, true);
    const Result<LibcameraPairs::Pair> pair = cameras.pairs().next();
    ASSERT_FALSE(pair);
    EXPECT_EQ(pair.error(), Status::kCorrupt);
    EXPECT_EQ(numbers(cameras), std::nullopt);
    EXPECT_EQ(cameras.queued(damaged), 4U);
  }
}

TEST(LibcameraPairs, WithAllSlotsOutFramesAreLostAndThenComeAgain) {
  constexpr int kSlots = 4;
  Cameras cameras(kSlots, 1);
  std::vector<int> lent;
  for (int n = 1; n < kSlots; ++n) {
    cameras.shoot(n);
    const Result<LibcameraPairs::Pair> pair = cameras.pairs().next();
    ASSERT_TRUE(pair) << n;
    lent.push_back(pair->number);
  }
  cameras.shoot(4);
  EXPECT_EQ(numbers(cameras), std::nullopt);
  EXPECT_EQ(cameras.queued(kLeft), 1U);
  cameras.pairs().give_back(lent.back());
  cameras.shoot(5);
  EXPECT_EQ(numbers(cameras), both(5));
}

TEST(LibcameraPairs, UnreadFramesMakeRoomForNewOnes) {
  Cameras cameras(6, 2);
  for (int n = 1; n <= 9; ++n) {
    cameras.shoot(n);
  }
  for (std::uint32_t n = 6; n <= 9; ++n) {
    EXPECT_EQ(numbers(cameras), both(n));
  }
  EXPECT_EQ(numbers(cameras), std::nullopt);
  EXPECT_EQ(cameras.queued(kLeft), 6U);
}

TEST(LibcameraPairs, WhatWasLentBeforeIsNotQueuedAfterwards) {
  Cameras cameras(4, 1);
  cameras.shoot(1);
  const Result<LibcameraPairs::Pair> old = cameras.pairs().next();
  cameras.trigger(2);
  cameras.fill(kLeft, 2);  // waits for its partner
  EXPECT_EQ(numbers(cameras), std::nullopt);
  ASSERT_TRUE(old);
  cameras.pairs().start_over();
  for (const std::size_t side : {kLeft, kRight}) {
    cameras.pairs().queue(side).reset(4, 1);
  }
  EXPECT_TRUE(cameras.pairs().old_ones_out());
  const std::size_t queued = cameras.queued(kLeft);
  cameras.pairs().give_back(old->number);
  EXPECT_EQ(cameras.queued(kLeft), queued);
  EXPECT_FALSE(cameras.pairs().old_ones_out());
  EXPECT_EQ(numbers(cameras), std::nullopt);
}

TEST(LibcameraBufferQueue, HandsEachSlotToOneThreadInOrder) {
  constexpr int kSlots = 6;
  constexpr std::uint32_t kFrames = 20'000;
  LibcameraBufferQueue queue;
  queue.reset(kSlots, 2);
  std::array<std::atomic<bool>, kSlots> free{};
  for (std::atomic<bool>& slot : free) {
    slot = true;
  }
  std::atomic<bool> done{false};
  std::thread camera([&] {
    for (std::uint32_t n = 1; n <= kFrames; ++n) {
      int slot = 0;
      while (!free[static_cast<std::size_t>(slot)].exchange(false)) {
        slot = (slot + 1) % kSlots;
      }
      const std::optional<int> back = queue.deliver(slot, {.stamp = {}, .sequence = n});
      if (back) {
        EXPECT_FALSE(free[static_cast<std::size_t>(*back)].exchange(true)) << "two owners";
      }
    }
    done = true;
  });
  std::uint32_t last = 0;
  while (!done) {
    const std::optional<int> slot = queue.take();
    if (slot) {
      const std::uint32_t sequence = queue.arrival(*slot).sequence;
      EXPECT_GT(sequence, last);
      last = sequence;
      queue.give_back(*slot);
      EXPECT_FALSE(free[static_cast<std::size_t>(*slot)].exchange(true)) << "two owners";
    }
  }
  camera.join();
}

TEST(FromLibcamera, StampBeyondTheMonotonicClockIsOfBoottime) {
  constexpr Duration kSlept = std::chrono::hours(2);
  constexpr Duration kNow = std::chrono::hours(5);
  constexpr Duration kStamp = kNow - milliseconds(20);
  EXPECT_EQ(from_libcamera(kStamp, kNow, kNow + kSlept), Time(kStamp));
  EXPECT_EQ(from_libcamera(kStamp + kSlept, kNow, kNow + kSlept), Time(kStamp));
  EXPECT_EQ(from_libcamera(kStamp, kNow, kNow), Time(kStamp));
}

TEST(FindLibcamera, TakesAPartAnExpressionOrTheNumberOfAModel) {
  const std::vector<LibcameraName> cameras{
      {"/base/soc/i2c0mux/i2c@0/imx296@1a", "imx296"},
      {"/base/soc/i2c0mux/i2c@1/imx296@1a", "imx296"},
      {"/base/usb-1:1.0-1209:0001", "Grey"},
  };
  EXPECT_EQ(find_libcamera(cameras, "i2c@1").value_or(9), 1U);
  EXPECT_EQ(find_libcamera(cameras, "i2c@0/.*296").value_or(9), 0U);
  EXPECT_EQ(find_libcamera(cameras, "model:imx296:1").value_or(9), 1U);
  EXPECT_EQ(find_libcamera(cameras, "model:Grey:0").value_or(9), 2U);
  for (const char* const wanted : {"", "imx296", "imx219", "(", "model:", "model:imx296",
                                   "model:imx296:2", "model:imx296:", "model:imx296:-1",
                                   "model:imx296:0x", "model:imx296:99999999999999999999"}) {
    const auto found = find_libcamera(cameras, wanted);
    ASSERT_FALSE(found) << wanted;
    EXPECT_NE(found.error().message.find("/base/usb-1:1.0-1209:0001 (Grey)"), std::string::npos);
    EXPECT_EQ(found.error().message.find('\n'), std::string::npos);
  }
  EXPECT_NE(find_libcamera({}, "x").error().message.find("no camera at all"), std::string::npos);
}

TEST(NoLibcamera, SaysWhatToUse) {
  const auto camera = hal::linux::open_libcamera({});
  ASSERT_FALSE(camera);
  EXPECT_EQ(camera.error().message,
            "this stofd was built without libcamera: use stofd-libcamera, or --cameras v4l2");
}

}  // namespace
}  // namespace stof::test
