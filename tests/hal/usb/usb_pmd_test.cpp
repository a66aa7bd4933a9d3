#include "hal/linux/usb/usb_pmd.h"

#include <chrono>
#include <cstdlib>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "hal/linux/system/clock.h"
#include "tests/hal/cameras/camera_contract.h"
#include "tests/hal/usb/fake_libusb.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::linux::UsbPmd;
using hal::linux::UsbPmdOptions;
using Wrong = FakeUsbCamera::Wrong;

UsbPmdOptions options_of(const FakeUsbCamera& usb) {
  UsbPmdOptions options;
  options.roots = {.devices = usb.sysfs(), .nodes = usb.nodes()};
  return options;
}

class UsbPmdRig {
 public:
  using Frame = hal::PmdFrame;
  static constexpr int kSlots = static_cast<int>(UsbPmd::kSlots);

  UsbPmdRig() {
    auto camera = UsbPmd::open(options_of(usb_), edges_);
    if (!camera) {
      ADD_FAILURE() << camera.error().message;
      std::abort();
    }
    camera_ = std::move(*camera);
  }

  hal::Clock& clock() { return clock_; }
  hal::Time pulse(Wrong wrong = Wrong::kNothing) {
    const hal::Time edge = clock_.now();
    edges_.note(edge);
    usb_.expose(edge, wrong);
    return edge;
  }
  auto wait_frame(hal::Time deadline) { return camera_->wait_frame(deadline); }
  auto shoot(Wrong wrong = Wrong::kNothing) { return wait_frame(pulse(wrong) + 20ms); }
  hal::Duration frame_time() { return 3ms; }
  static std::vector<hal::Exposure> exposures(const Frame& frame) {
    return {frame.exposures.begin(), frame.exposures.end()};
  }
  static std::uint32_t sequence(const Frame& frame) { return frame.sequence; }
  static std::vector<std::uint8_t> bytes(const Frame& frame) {
    std::vector<std::uint8_t> out;
    for (const auto& sample : frame.samples) {
      for (int y = 0; y < sample.height(); ++y) {
        for (const std::uint16_t pixel : sample.row(y)) {
          out.push_back(static_cast<std::uint8_t>(pixel));
          out.push_back(static_cast<std::uint8_t>(pixel >> 8));
        }
      }
    }
    return out;
  }

  FakeUsbCamera& usb() { return usb_; }
  UsbPmd& camera() { return *camera_; }
  void close() { camera_.reset(); }

 private:
  hal::linux::Clock clock_;
  FakeUsbCamera usb_;
  hal::linux::EdgeLog edges_;
  std::unique_ptr<UsbPmd> camera_;
};

INSTANTIATE_TYPED_TEST_SUITE_P(Usb, CameraContract, testing::Types<UsbPmdRig>);

TEST(UsbPmd, ShowsThePicturesAndCountsExposuresFromItsEdge) {
  UsbPmdRig rig;
  const hal::Time edge = rig.pulse();
  const auto frame = rig.wait_frame(edge + 20ms);
  ASSERT_TRUE(frame);
  EXPECT_EQ((*frame)->exposures[0].begin, edge) << "snapped to the edge, to the nanosecond";
  EXPECT_EQ((*frame)->exposures[3].end, edge + 800us);
  EXPECT_EQ((*frame)->samples[3].at(11, 6), 0x0101);
  EXPECT_EQ(rig.usb().config.modulation_khz, 20'000U);
}

TEST(UsbPmd, DropsWhatIsDamagedAndGoesOn) {
  for (const Wrong wrong : {Wrong::kShort, Wrong::kLong, Wrong::kMagic, Wrong::kSequence,
                            Wrong::kError, Wrong::kOverflow}) {
    UsbPmdRig rig;
    ASSERT_TRUE(rig.shoot());
    const auto bad = rig.shoot(wrong);
    ASSERT_FALSE(bad);
    EXPECT_EQ(bad.error(), Status::kCorrupt) << static_cast<int>(wrong);
    EXPECT_TRUE(rig.shoot());
  }
}

TEST(UsbPmd, SetsAStalledEndpointGoingAgain) {
  UsbPmdRig rig;
  const auto stalled = rig.shoot(Wrong::kStall);
  ASSERT_FALSE(stalled);
  EXPECT_EQ(stalled.error(), Status::kDeviceError);
  EXPECT_EQ(rig.usb().halts_cleared, 1);
  for (int i = 0; i < 8; ++i) {
    EXPECT_TRUE(rig.shoot()) << "frame " << i;
  }
}

TEST(UsbPmd, FrameFarFromEveryEdgeBelongsToNone) {
  UsbPmdRig rig;
  const hal::Time edge = rig.pulse(Wrong::kStamp);
  const auto frame = rig.wait_frame(edge + 20ms);
  ASSERT_TRUE(frame);
  EXPECT_GT((*frame)->exposures[0].begin, edge + 5ms);
}

TEST(UsbPmd, CameraThatOnlySendsRubbishIsLost) {
  UsbPmdRig rig;
  Status last = Status::kOk;
  int calls = 0;
  while (last != Status::kDeviceLost && calls < 100) {
    const auto frame = rig.shoot(Wrong::kMagic);
    ASSERT_FALSE(frame);
    last = frame.error();
    ++calls;
  }
  EXPECT_LT(calls, 40);
}

TEST(UsbPmd, UnpluggedIsLostAndPluggedInAgainReopensWithFramesLent) {
  UsbPmdRig rig;
  const auto held = rig.shoot();
  ASSERT_TRUE(held);
  const std::vector<std::uint8_t> before = UsbPmdRig::bytes(**held);
  rig.usb().unplug();
  const auto gone = rig.shoot();
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error(), Status::kDeviceLost);
  EXPECT_EQ(rig.camera().reopen(), Status::kDeviceLost);
  EXPECT_FALSE(rig.camera().trouble().empty());
  EXPECT_EQ(rig.wait_frame(rig.clock().now() + 1ms).error(), Status::kDeviceLost);
  rig.usb().plugged = true;
  rig.usb().clock_shift = -100'000'000'000;  // its clock begins anew
  ASSERT_EQ(rig.camera().reopen(), Status::kOk) << rig.camera().trouble();
  for (int i = 0; i < 10; ++i) {
    const auto frame = rig.shoot();
    ASSERT_TRUE(frame);
    EXPECT_EQ((*frame)->sequence, static_cast<std::uint32_t>(i + 1));
  }
  EXPECT_EQ(before, UsbPmdRig::bytes(**held));
}

TEST(UsbPmd, AnotherCameraThanBeforeIsNotTaken) {
  UsbPmdRig rig;
  rig.usb().info.width = 24;
  EXPECT_EQ(rig.camera().reopen(), Status::kDeviceLost);
  EXPECT_NE(rig.camera().trouble().find("another size"), std::string::npos);
}

TEST(UsbPmd, ClosesWithoutLeavingAnythingAlsoWhenTheDeviceIsGone) {
  for (const bool gone : {false, true}) {
    UsbPmdRig rig;
    ASSERT_TRUE(rig.shoot());
    rig.usb().plugged = !gone;
    rig.close();
    EXPECT_EQ(rig.usb().open_devices, 0);
    EXPECT_EQ(rig.usb().transfers, 0);
    EXPECT_EQ(rig.usb().streaming, gone);
  }
}

TEST(UsbPmd, FollowsAClockThatDrifts) {
  UsbPmdRig rig;
  for (int i = 0; i < 50; ++i) {
    rig.usb().clock_shift += 10'000;  // 10 us an edge
    const hal::Time edge = rig.pulse();
    const auto frame = rig.wait_frame(edge + 20ms);
    ASSERT_TRUE(frame);
    ASSERT_EQ((*frame)->exposures[0].begin, edge);
  }
}

std::string refusal(const FakeUsbCamera& usb, const UsbPmdOptions& options) {
  const hal::linux::EdgeLog edges;
  const auto camera = UsbPmd::open(options, edges);
  EXPECT_FALSE(camera);
  EXPECT_EQ(usb.open_devices, 0);
  EXPECT_EQ(usb.transfers, 0);
  return camera ? std::string() : camera.error().message;
}

TEST(UsbPmd, SaysInOneLineWhyItDoesNotOpen) {
  FakeUsbCamera usb;
  UsbPmdOptions options = options_of(usb);
  options.id.product = 0x51;
  EXPECT_NE(refusal(usb, options).find("not plugged in"), std::string::npos);
  options = options_of(usb);
  options.config.modulation_khz = 1;
  EXPECT_NE(refusal(usb, options).find("give 1000 to 100000 kHz"), std::string::npos);
  options = options_of(usb);
  options.config.integration_us = 6000;
  EXPECT_NE(refusal(usb, options).find("give 10 to 5000 us"), std::string::npos);
  options = options_of(usb);
  options.width = 640;
  EXPECT_NE(refusal(usb, options).find("12 x 7"), std::string::npos);
  options = options_of(usb);
  usb.claim_error = -6;
  EXPECT_NE(refusal(usb, options).find("another program"), std::string::npos);
  usb.claim_error = 0;
  usb.refuses_config = true;
  EXPECT_NE(refusal(usb, options).find("does not take"), std::string::npos);
  usb.damaged_info = true;
  EXPECT_NE(refusal(usb, options).find("update its firmware"), std::string::npos);
  usb.answers = false;
  EXPECT_NE(refusal(usb, options).find("does not say what it is"), std::string::npos);
}

}  // namespace
}  // namespace stof::test
