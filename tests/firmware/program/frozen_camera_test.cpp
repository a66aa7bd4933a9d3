#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/program/reopener.h"
#include "tests/firmware/rig.h"

// A camera that repeats its last picture is opened again beside the loop.
namespace stof::board {
namespace {

std::atomic<int> openings = 0;
std::function<void(Device)> on_open;

}  // namespace

Status reopen(Board& /*board*/, Device device) noexcept {
  ++openings;
  if (on_open) {
    on_open(device);
  }
  return Status::kOk;
}

}  // namespace stof::board

namespace stof::firmware::test {
namespace {

constexpr std::size_t kFirst = 40;         // edge of the outage
constexpr std::size_t kForever = 100'000;  // edges
constexpr std::size_t kThawed = ~std::size_t{0};
constexpr hal::Duration kPeriod = 33ms;
// Of three edges in a row each waits for another picture until the next one.
const std::vector<std::size_t> kTold{kFirst + 3};

struct Camera {
  PixelFault PixelFaults::* pixels;
  board::Device device;
  Sensors goes_on;
  wire::Condition frozen;
};
constexpr std::array kCameras{
    Camera{&PixelFaults::left, board::Device::kStereo, kPmdSensor, wire::Condition::kStereoFrozen},
    Camera{&PixelFaults::right, board::Device::kStereo, kPmdSensor, wire::Condition::kStereoFrozen},
    Camera{&PixelFaults::pmd, board::Device::kPmd, kStereoSensor, wire::Condition::kPmdFrozen}};

// The real loop with a thread that opens its devices. The camera's pictures are frozen from edge
// kFirst on, for so many edges or until the test says otherwise.
class FrozenRig {
 public:
  // wait: emulated time stands still while a camera is opened.
  explicit FrozenRig(const Camera& camera, std::size_t edges = kForever, bool wait = true)
      : camera_(camera), wait_(wait), lending_(false), rig_(options(camera, edges)) {
    board::openings = 0;
    board::on_open = nullptr;
    rig_.board.emulated_time = false;
    reopener_.emplace(rig_.board, lending_);
  }
  ~FrozenRig() {
    reopener_.reset();
    board::on_open = nullptr;
  }
  FrozenRig(const FrozenRig&) = delete;
  FrozenRig& operator=(const FrozenRig&) = delete;

  void step() {
    static_cast<void>(rig_.loop.step());
    rig_.publisher.report({});
    receiver_.drain(rig_.port);
    for (int i = 0; wait_ && i < 60'000 && !lending_.usable(camera_.device); ++i) {
      std::this_thread::sleep_for(1ms);
    }
  }
  void steps(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      step();
    }
  }

  // The edges of all frames; each of them is true, and new.
  std::vector<std::size_t> frames() { return expect_true_frames(rig_, receiver_); }
  Sensors sensors(std::size_t edge) const {
    for (const auto& [number, frame] : receiver_.frames) {
      if (rig_.log.find(hal::Time(hal::Duration(frame.info.exposure_begin_ns))) == edge) {
        return static_cast<Sensors>(frame.info.sensors);
      }
    }
    return kNoSensor;
  }
  // Edges at which that began or ended to be told.
  std::vector<std::size_t> told(wire::Condition condition, bool active) const {
    std::vector<std::size_t> out;
    for (const wire::EventReport& event : receiver_.events) {
      if (event.condition == static_cast<std::uint8_t>(condition) &&
          (event.active != 0) == active) {
        const hal::Time at{hal::Duration(event.at_ns)};
        const auto after = std::ranges::upper_bound(rig_.log.edges, at);
        out.push_back(static_cast<std::size_t>(after - rig_.log.edges.begin()) - 1);
      }
    }
    const auto again = std::ranges::unique(out);  // each is sent twice
    out.erase(again.begin(), again.end());
    return out;
  }
  std::size_t edges() const { return rig_.log.edges.size(); }
  const Rig& rig() const { return rig_; }
  void thaw() { since_ = kThawed; }
  bool is_thawed() const { return since_ == kThawed; }
  void freeze_from(std::size_t edge) { since_ = edge; }
  const Receiver& receiver() const { return receiver_; }

 private:
  RigOptions options(const Camera& camera, std::size_t edges) {
    RigOptions out;
    out.pixels.*camera.pixels = {.first = kFirst, .edges = edges, .since = &since_};
    out.lending = &lending_;
    return out;
  }

  Camera camera_;
  bool wait_;
  std::atomic<std::size_t> since_ = kFirst;
  DeviceLending lending_;
  Rig rig_;
  Receiver receiver_;
  std::optional<Reopener> reopener_;
};

TEST(FrozenCamera, ThatThawsWhenItIsOpenedIsBackAtOnce) {
  for (const Camera& camera : kCameras) {
    FrozenRig rig(camera);
    board::on_open = [&](board::Device device) {
      if (device == camera.device) {
        rig.thaw();
      }
    };
    rig.steps(kFirst + 40);
    EXPECT_EQ(board::openings, 1);
    EXPECT_GE(rig.frames().size(), rig.edges() - 1) << "no edge is without a frame";
    for (std::size_t edge = 0; edge + 1 < rig.edges(); ++edge) {
      const bool out = edge >= kFirst && edge < kFirst + 3;  // it is told at the third
      EXPECT_EQ(rig.sensors(edge), out ? camera.goes_on : kBothSensors) << edge;
    }
    EXPECT_EQ(rig.told(camera.frozen, true), kTold);
    EXPECT_EQ(rig.told(camera.frozen, false), std::vector{kFirst + 3});
    EXPECT_TRUE(rig.told(wire::Condition::kStereoLost, true).empty());
    EXPECT_TRUE(rig.told(wire::Condition::kPmdLost, true).empty());
  }
}

TEST(FrozenCamera, ThatThawsAtAnOpeningTenSecondsLaterIsBackWithinTwo) {
  for (const Camera& camera : kCameras) {
    FrozenRig rig(camera);
    const std::size_t ready = kFirst + 303;
    board::on_open = [&](board::Device) {
      if (rig.edges() >= ready) {
        rig.thaw();
      }
    };
    rig.steps(ready + 70);
    rig.frames();
    const std::vector<std::size_t> back = rig.told(camera.frozen, false);
    ASSERT_EQ(back.size(), 1U) << "told once, whatever was tried meanwhile";
    EXPECT_LE((back[0] - ready) * kPeriod, 2s);
    EXPECT_EQ(rig.sensors(back[0] - 1), camera.goes_on);
    EXPECT_EQ(rig.sensors(back[0]), kBothSensors);
  }
}

TEST(FrozenCamera, ThatThawsByItselfIsOpenedOnceASecondAtMostAndBackAtOnce) {
  for (const Camera& camera : kCameras) {
    constexpr std::size_t kEdges = 303;  // 10 s
    FrozenRig rig(camera, kEdges);
    rig.steps(kFirst + kEdges + 20);
    rig.frames();
    EXPECT_GE(board::openings, 10);
    EXPECT_LE(board::openings, 13) << "at once, after .25, .5 and 1 s, then each second";
    EXPECT_EQ(rig.told(camera.frozen, true), kTold);
    EXPECT_EQ(rig.told(camera.frozen, false), std::vector{kFirst + kEdges});
    for (const wire::EventReport& event : rig.receiver().events) {
      EXPECT_EQ(event.condition, static_cast<std::uint8_t>(camera.frozen)) << "nothing else";
    }
    EXPECT_EQ(rig.sensors(kFirst + kEdges), kBothSensors);
  }
}

// One new picture after each opening, and then that one for good.
TEST(FrozenCamera, ThatFreezesAgainAndAgainIsNotOpenedMoreOften) {
  const Camera& camera = kCameras[0];
  FrozenRig rig(camera);
  std::atomic<std::size_t> opened_at = 0;
  board::on_open = [&](board::Device) {
    opened_at = rig.edges();
    rig.thaw();
  };
  for (std::size_t i = 0; i < kFirst + 303; ++i) {
    rig.step();
    if (rig.is_thawed() && rig.edges() > opened_at) {
      rig.freeze_from(rig.edges());
    }
  }
  rig.frames();
  EXPECT_LE(board::openings, 13);
}

// However long a driver takes, the loop keeps its grid, and the camera is frozen, not lost.
TEST(FrozenCamera, WhileItIsOpenedTheOtherSensorGoesOn) {
  for (const Camera& camera : kCameras) {
    std::atomic<bool> hangs = true;  // outlives who opens, which the rig waits for
    FrozenRig rig(camera, kForever, false);
    board::on_open = [&](board::Device) {
      hangs.wait(true);
      rig.thaw();
    };
    rig.steps(kFirst + 60);
    EXPECT_LE(board::openings, 1);
    const std::vector<hal::Time>& edges = rig.rig().log.edges;
    for (std::size_t i = 1; i < edges.size(); ++i) {
      EXPECT_EQ(edges[i] - edges[i - 1], kPeriod) << i;
    }
    EXPECT_GE(rig.frames().size(), edges.size() - 1);
    EXPECT_EQ(rig.told(camera.frozen, true), kTold);
    EXPECT_TRUE(rig.told(camera.frozen, false).empty());
    EXPECT_TRUE(rig.told(wire::Condition::kStereoLost, true).empty());
    EXPECT_TRUE(rig.told(wire::Condition::kPmdLost, true).empty());
    hangs = false;
    hangs.notify_all();
  }
}

}  // namespace
}  // namespace stof::firmware::test
