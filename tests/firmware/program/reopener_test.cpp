#include "firmware/program/reopener.h"

#include <atomic>
#include <thread>

#include <gtest/gtest.h>

#include "tests/firmware/rig.h"

namespace stof::board {
namespace {

std::atomic<int> tries = 0;
std::atomic<bool> opening = false;
std::atomic<bool> hangs = false;
std::atomic<bool> comes_back = false;

}  // namespace

// Of a board whose drivers hang as long as they are told to.
Status reopen(Board& /*board*/, Device /*device*/) noexcept {
  opening = true;
  ++tries;
  hangs.wait(true);
  opening = false;
  return comes_back ? Status::kOk : Status::kDeviceLost;
}

}  // namespace stof::board

namespace stof::firmware::test {
namespace {

void wait_until(const auto& condition) {
  for (int i = 0; i < 60'000 && !condition(); ++i) {
    std::this_thread::sleep_for(1ms);
  }
  ASSERT_TRUE(condition());
}

// The rig's pair, which can be unplugged. Nobody may use it while it is being opened.
class UnpluggedStereo final : public hal::StereoCamera {
 public:
  explicit UnpluggedStereo(hal::StereoCamera& camera) : camera_(camera) {}
  Result<hal::BorrowedFrame<hal::StereoFrame>> wait_frame(hal::Time deadline) noexcept override {
    EXPECT_FALSE(board::opening) << "used while it is lent";
    if (unplugged && !board::comes_back) {
      return fail(Status::kDeviceLost);
    }
    unplugged = false;
    return camera_.wait_frame(deadline);
  }

  bool unplugged = false;

 private:
  hal::StereoCamera& camera_;
};

// The real loop with a thread that opens its devices; the rig's clock, though nobody is told that
// it is emulated.
struct LentRig {
  Rig rig;
  UnpluggedStereo stereo{rig.painted_stereo};
  board::Board board{.clock = rig.clock,
                     .trigger = rig.trigger,
                     .stereo = stereo,
                     .pmd = &rig.painted_pmd,
                     .port = rig.port,
                     .serial = nullptr,
                     .to = std::nullopt,
                     .network = rig.network,
                     .mdns = nullptr,
                     .calibration = rig.setup.calibration,
                     .disparities = kDisparities,
                     .emulated_time = false,
                     .notes = {}};
  DeviceLending lending{board.emulated_time};
  Loop loop{board, timing(), rig.setup, rig.pipeline, rig.publisher, rig.events, &lending};

  Status step() {
    const Status status = loop.step();
    while (rig.port.take_sent()) {
    }
    return status;
  }
};

TEST(Reopener, TheLoopKeepsItsGridWhileADeviceIsBeingOpened) {
  board::tries = 0;
  board::hangs = true;
  board::comes_back = false;
  LentRig lent;
  const Reopener reopener(lent.board, lent.lending);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(lent.step(), Status::kOk);
  }
  lent.stereo.unplugged = true;
  EXPECT_EQ(lent.step(), Status::kDeviceLost);
  wait_until([] { return board::opening.load(); });
  const hal::Time began = lent.rig.clock.now();
  int steps = 0;
  for (; lent.rig.clock.now() - began < 500ms; ++steps) {
    EXPECT_EQ(lent.step(), Status::kDeviceLost);
  }
  EXPECT_EQ(board::tries, 1);
  EXPECT_GE(steps, 15);
  const std::vector<hal::Time>& edges = lent.rig.log.edges;
  for (std::size_t i = 1; i < edges.size(); ++i) {
    EXPECT_EQ(edges[i] - edges[i - 1], 33ms) << "the loop waited at edge " << i;
  }
  EXPECT_EQ(lent.rig.events.counters.skipped_periods, 0U);
  EXPECT_EQ(lent.rig.events.counters.published, edges.size()) << "of the PMD camera alone";
  board::comes_back = true;
  board::hangs = false;
  board::hangs.notify_all();
  wait_until([&] { return lent.lending.usable(board::Device::kStereo); });
  for (int i = 0; i < 10; ++i) {
    static_cast<void>(lent.step());
  }
  EXPECT_EQ(lent.rig.events.counters.published, edges.size());
  int lost = 0;
  int back = 0;
  while (const auto event = lent.rig.events.take()) {
    lost += event->kind == EventKind::kLost ? 1 : 0;
    back += event->kind == EventKind::kBack ? 1 : 0;
  }
  EXPECT_EQ(lost, 1);
  EXPECT_EQ(back, 1);
}

TEST(Reopener, ADeviceThatStaysAwayIsTriedAgainAndAgain) {
  board::tries = 0;
  board::hangs = false;
  board::comes_back = false;
  LentRig lent;
  const Reopener reopener(lent.board, lent.lending);
  lent.stereo.unplugged = true;
  const hal::Time began = lent.rig.clock.now();
  while (lent.rig.clock.now() - began < 5s) {
    EXPECT_EQ(lent.step(), Status::kDeviceLost);
    wait_until([&] { return lent.lending.usable(board::Device::kStereo); });
  }
  EXPECT_GE(board::tries, 15);
  EXPECT_LE(board::tries, 22);
}

TEST(Reopener, ItsEndWaitsForATryThatGoesOn) {
  board::hangs = true;
  board::comes_back = false;
  LentRig lent;
  std::optional<Reopener> reopener(std::in_place, lent.board, lent.lending);
  lent.stereo.unplugged = true;
  static_cast<void>(lent.step());
  wait_until([] { return board::opening.load(); });
  std::thread driver([] {
    std::this_thread::sleep_for(20ms);
    board::hangs = false;
    board::hangs.notify_all();
  });
  reopener.reset();
  EXPECT_FALSE(board::opening);
  driver.join();
}

}  // namespace
}  // namespace stof::firmware::test
