#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "hal/linux/v4l2/v4l2_find.h"
#include "tests/hal/v4l2/v4l2_pmd_rig.h"
#include "tests/hal/v4l2/v4l2_rigs.h"

namespace stof::test {
namespace {

using namespace std::chrono_literals;
using hal::linux::find_v4l2_node;
using hal::linux::kGrey;
using hal::linux::kY10;
using hal::linux::kYuyv;
using hal::linux::V4l2Stereo;
using Stereo = V4l2StereoRig<kGrey, false>;

// Opens the rig's cameras anew after `change`; the message of the refusal.
template <typename Change>
std::string refusal(const Change& change) {
  Stereo rig;
  rig.close();
  hal::linux::V4l2StereoOptions options = rig.options();
  change(rig, options);
  const auto opened = V4l2Stereo::open(rig.kernel(), rig.clock(), options);
  EXPECT_FALSE(opened);
  EXPECT_EQ(rig.kernel().mappings(), 0U);
  EXPECT_EQ(rig.kernel().open_files(), 0);
  return opened ? "" : opened.error().message;
}

TEST(V4l2Open, NamesTheSizesOfACameraWithAnother) {
  const std::string message = refusal([](Stereo& rig, auto&) {
    rig.fake(1).width = 640;
    rig.fake(1).height = 480;
    rig.fake(1).formats = {kGrey, kYuyv};
  });
  EXPECT_EQ(message,
            "camera '/dev/video2' (/dev/video2): does not give 8x4 in GREY, Y10, Y12, Y16, YUYV, "
            "it offers GREY 640x480, YUYV 640x480; set the size to one of these, or use another "
            "one");
}

TEST(V4l2Open, TakesTheFirstFormatThatTheCameraHas) {
  V4l2StereoRig<kY10, false> rig;
  rig.close();
  rig.fake(0).formats = {kYuyv, kY10};
  auto options = rig.options();
  EXPECT_TRUE(V4l2Stereo::open(rig.kernel(), rig.clock(), options));
  options.formats = {kGrey};
  EXPECT_FALSE(V4l2Stereo::open(rig.kernel(), rig.clock(), options));
}

TEST(V4l2Open, SetsExposureGainAndASteadyRate) {
  Stereo rig;
  for (const std::size_t side : {0U, 1U}) {
    auto& controls = rig.fake(side).controls;
    EXPECT_EQ(controls[V4L2_CID_EXPOSURE_AUTO].value, V4L2_EXPOSURE_MANUAL);
    EXPECT_EQ(controls[V4L2_CID_EXPOSURE_AUTO_PRIORITY].value, 0);
    EXPECT_EQ(controls[V4L2_CID_EXPOSURE_ABSOLUTE].value, 8);
    EXPECT_EQ(controls[V4L2_CID_GAIN].value, 7);
  }
  EXPECT_EQ(rig.camera().exposure(), 800us);
}

TEST(V4l2Open, RefusesExposuresThatDiffer) {
  const std::string message = refusal(
      [](Stereo& rig, auto&) { rig.fake(1).controls[V4L2_CID_EXPOSURE_ABSOLUTE].quantum = 7; });
  EXPECT_EQ(message,
            "camera '/dev/video0' (/dev/video0): exposes for 800 us, camera '/dev/video2' "
            "(/dev/video2) for 700 us; use two cameras of one kind");
  const std::string untold =
      refusal([](Stereo& rig, auto&) { rig.fake(0).controls.erase(V4L2_CID_EXPOSURE_ABSOLUTE); });
  EXPECT_NE(untold.find("for a time that it does not tell"), std::string::npos) << untold;
}

TEST(V4l2Open, RefusesWhatTheCameraMakesOfTheExposure) {
  const std::string other = refusal(
      [](Stereo& rig, auto&) { rig.fake(0).controls[V4L2_CID_EXPOSURE_ABSOLUTE].quantum = 5; });
  EXPECT_NE(other.find("exposes for 500 us where 800 us were asked"), std::string::npos) << other;
  const std::string outside = refusal([](Stereo&, auto& options) { options.exposure = 2s; });
  EXPECT_NE(outside.find("give 100 us to 500000 us"), std::string::npos) << outside;
  const std::string gain = refusal([](Stereo&, auto& options) { options.gain = 101; });
  EXPECT_NE(gain.find("does not take gain 101; give 0 to 100"), std::string::npos) << gain;
  const std::string automatic =
      refusal([](Stereo& rig, auto&) { rig.fake(0).controls[V4L2_CID_EXPOSURE_AUTO].quantum = 2; });
  EXPECT_NE(automatic.find("does not expose by hand"), std::string::npos) << automatic;
}

TEST(V4l2Open, CamerasWithoutControlsAreTaken) {
  Stereo rig;
  rig.close();
  rig.fake(0).controls.clear();
  rig.fake(1).controls.clear();
  const auto opened = V4l2Stereo::open(rig.kernel(), rig.clock(), rig.options());
  ASSERT_TRUE(opened);
  EXPECT_FALSE((*opened)->exposure());
}

TEST(V4l2Open, RefusesOtherClocksFewBuffersAndWhatDoesNotCapture) {
  const std::string clock =
      refusal([](Stereo& rig, auto&) { rig.fake(1).stamps = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN; });
  EXPECT_NE(clock.find("CLOCK_MONOTONIC"), std::string::npos) << clock;
  const std::string buffers = refusal([](Stereo& rig, auto&) { rig.fake(1).most_buffers = 4; });
  EXPECT_NE(buffers.find("gives 4 buffers, 5 are needed"), std::string::npos) << buffers;
  const std::string metadata =
      refusal([](Stereo& rig, auto&) { rig.fake(0).caps = V4L2_CAP_META_CAPTURE; });
  EXPECT_NE(metadata.find("does not capture"), std::string::npos) << metadata;
  const std::string missing =
      refusal([](Stereo&, auto& options) { options.nodes[0] = "/dev/video9"; });
  EXPECT_NE(missing.find("'/dev/video9' (/dev/video9): cannot be opened"), std::string::npos)
      << missing;
}

TEST(V4l2Open, CameraThatAnotherHasIsBusy) {
  Stereo rig;
  const auto second = V4l2Stereo::open(rig.kernel(), rig.clock(), rig.options());
  ASSERT_FALSE(second);
  EXPECT_NE(second.error().message.find("another program has it"), std::string::npos)
      << second.error().message;
  EXPECT_TRUE(rig.shoot());
}

TEST(KernelCalls, AreTheSystemsOwn) {
  hal::linux::V4l2Calls& calls = hal::linux::kernel_calls();
  EXPECT_LT(calls.open("/dev/no such node"), 0);
  const int fd = calls.open("/dev/zero");
  ASSERT_GE(fd, 0);
  const std::uint8_t* const data = calls.map(fd, 4096, 0);
  ASSERT_NE(data, nullptr);
  EXPECT_EQ(data[4095], 0);
  calls.unmap(data, 4096);
  pollfd entry{.fd = fd, .events = POLLIN, .revents = 0};
  EXPECT_EQ(calls.poll(std::span(&entry, 1), 1s), 1);
  calls.close(fd);
  EXPECT_EQ(calls.map(fd, 4096, 0), nullptr);
  EXPECT_EQ(calls.poll({}, 1ms), 0);
}

TEST(KernelCalls, WhatIsNoCameraIsToldSo) {
  Stereo rig;
  auto options = rig.options();
  options.nodes[0] = "/dev/null";
  const auto opened = V4l2Stereo::open(hal::linux::kernel_calls(), rig.clock(), options);
  ASSERT_FALSE(opened);
  EXPECT_TRUE(
      opened.error().message.starts_with("camera '/dev/null' (/dev/null): is no video device: "))
      << opened.error().message;
}

// /sys as the kernel lays it out: a node's device is a link to a USB interface.
class V4l2Find : public testing::Test {
 protected:
  V4l2Find() : root_(std::filesystem::path(testing::TempDir()) / unique_name()) {
    std::filesystem::create_directories(root_ / "class/video4linux");
  }
  ~V4l2Find() override { std::filesystem::remove_all(root_); }

  static std::string unique_name() {
    return std::string("stof_sys_") + testing::UnitTest::GetInstance()->current_test_info()->name();
  }
  void put(const std::string& node, const std::string& port, const std::string& vendor,
           const std::string& serial, std::uint32_t caps, const std::string& card = "Fake") {
    const std::filesystem::path device = root_ / "devices" / port;
    const std::filesystem::path interface = device / (port + ":1.0");
    std::filesystem::create_directories(interface);
    std::ofstream(device / "idVendor") << vendor << "\n";
    std::ofstream(device / "idProduct") << "0c45\n";
    if (!serial.empty()) {
      std::ofstream(device / "serial") << serial << "\n";
    }
    const std::filesystem::path place = root_ / "class/video4linux" / node;
    std::filesystem::create_directories(place);
    std::filesystem::create_directory_symlink(interface, place / "device");
    FakeCamera camera{.path = "/dev/" + node};
    camera.card = card;
    camera.caps = caps;
    kernel_.add(std::move(camera));
  }
  // The node, or the refusal.
  std::string find(const std::string& text) {
    const auto found = find_v4l2_node(kernel_, text, root_);
    EXPECT_EQ(kernel_.open_files(), 0);
    return found ? *found : found.error().message;
  }

  static constexpr std::uint32_t kCapture = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  static constexpr std::uint32_t kMetadata = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  hal::emu::Clock clock_;
  FakeV4l2 kernel_{clock_};
  std::filesystem::path root_;
};

TEST_F(V4l2Find, PassesOverMetadataAndKnowsSerialNumbers) {
  put("video0", "1-1", "0bda", "L", kMetadata);
  put("video1", "1-1", "0bda", "L", kCapture);
  put("video2", "1-2", "0bda", "R", kCapture);
  put("video10", "1-2", "0bda", "R", kCapture);
  EXPECT_EQ(find("usb:0BDA:0c45:L"), "/dev/video1");
  EXPECT_EQ(find("usb:0bda:0C45:R"), "/dev/video2");
  EXPECT_EQ(find("/dev/video7"), "/dev/video7");
  EXPECT_EQ(find("usb:0bda:0c45"),
            "camera 'usb:0bda:0c45': two of them are there; add its serial number or give "
            "/dev/videoN");
}

TEST_F(V4l2Find, KnowsCardsByName) {
  put("video0", "1-1", "0bda", "", kMetadata, "Left: one");
  put("video3", "1-1", "0bda", "", kCapture, "Left: one");
  put("video4", "1-2", "0bdb", "", kCapture, "Right");
  EXPECT_EQ(find("card:Left: one"), "/dev/video3");
  EXPECT_EQ(find("card:Right"), "/dev/video4");
  EXPECT_EQ(find("usb:0bdb:0c45"), "/dev/video4");
}

TEST_F(V4l2Find, RefusesWhatIsNotThereOrNoName) {
  put("video0", "1-1", "0bda", "", kCapture);
  for (const char* const text : {"usb:0bda:0c46", "card:Other", "usb:0bda:0c45:X", "card:"}) {
    EXPECT_EQ(find(text), "camera '" + std::string(text) +
                              "': not there, or not to be opened; check the cable and the group "
                              "video");
  }
  for (const char* const text : {"", "video0", "usb:", "usb:0bda", "usb:0bda:0c4", "usb:0bda-0c45",
                                 "usb:0bda:0c45x", "usb:0bdg:0c45", "USB:0bda:0c45"}) {
    EXPECT_EQ(find(text), "camera '" + std::string(text) +
                              "': no such form; give /dev/videoN, usb:VVVV:PPPP[:SERIAL] or "
                              "card:NAME");
  }
  EXPECT_NE(find_v4l2_node(kernel_, "card:Fake", root_ / "none"), "/dev/video0");
}

TEST_F(V4l2Find, CameraIsFoundAgainUnderAnotherNumber) {
  Stereo rig;
  put("video0", "1-1", "0bda", "L", kCapture);
  rig.close();
  hal::linux::V4l2StereoOptions options = rig.options();
  options.nodes[0] = "usb:0bda:0c45:L";
  options.sysfs = root_;
  const auto camera = V4l2Stereo::open(rig.kernel(), rig.clock(), options);
  ASSERT_TRUE(camera) << camera.error().message;
  rig.kernel().unplug(rig.fake(0));
  EXPECT_EQ((*camera)->reopen(), Status::kDeviceLost);
  rig.kernel().plug(rig.fake(0), "/dev/video5");
  std::filesystem::rename(root_ / "class/video4linux/video0", root_ / "class/video4linux/video5");
  EXPECT_EQ((*camera)->reopen(), Status::kOk);
  const hal::Time edge = rig.pulse();
  EXPECT_TRUE((*camera)->wait_frame(edge + 3ms));
}

}  // namespace
}  // namespace stof::test
