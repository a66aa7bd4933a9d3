#include "board/devices/device_options.h"

#include <gtest/gtest.h>

#include "board/devices/nominal_rig.h"

namespace stof::board {
namespace {

using Arguments = std::vector<std::string_view>;

std::string refusal(const Arguments& arguments) {
  const auto options = parse_device_options(arguments);
  return options ? std::string() : options.error().message;
}

TEST(DeviceRequest, WithoutFlagsIsTheTable) {
  const auto options = parse_device_options({});
  ASSERT_TRUE(options);
  EXPECT_EQ(options->cameras, PairKind::kV4l2);
  EXPECT_TRUE(options->left.empty());
  EXPECT_EQ(options->pmd, "usb");
  EXPECT_FALSE(options->size || options->pmd_size || options->gain || options->priority);
  EXPECT_FALSE(options->uncalibrated);
  const std::array<std::string, 2> wired{kConfig.devices.nets.left_strobe.line,
                                         kConfig.devices.nets.right_strobe.line};
  EXPECT_EQ(strobe_lines(*options), wired);
}

TEST(DeviceRequest, TakesEveryFlag) {
  const Arguments all{"--cameras",  "libcamera", "--left",     "a",       "--right",
                      "none",       "--size",    "640x400",    "--gain",  "7",
                      "--pmd",      "card:tof",  "--pmd-size", "160x120", "--uncalibrated",
                      "--watchdog", "none",      "--priority", "0"};
  const auto options = parse_device_options(all);
  ASSERT_TRUE(options) << refusal(all);
  EXPECT_EQ(options->cameras, PairKind::kLibcamera);
  EXPECT_EQ(options->left, "a");
  EXPECT_EQ(options->right, "none");
  EXPECT_EQ(options->size->width, 640);
  EXPECT_EQ(options->size->height, 400);
  EXPECT_EQ(options->pmd_size->width, 160);
  EXPECT_EQ(options->gain, 7);
  EXPECT_EQ(options->priority, 0);
  EXPECT_EQ(options->watchdog, "none");
  EXPECT_TRUE(options->uncalibrated);
}

TEST(DeviceRequest, TakesTheButtonsLineOrNone) {
  EXPECT_EQ(button_line({}), kConfig.devices.nets.pair_button.line);
  for (const auto& [value, line] : {std::pair("GPIO6", "GPIO6"), std::pair("none", "")}) {
    const Arguments flags{"--pair-button", value};
    const auto options = parse_device_options(flags);
    ASSERT_TRUE(options) << refusal(flags);
    EXPECT_EQ(button_line(*options), line);
  }
}

TEST(DeviceRequest, TakesStrobeLinesOrNone) {
  const Arguments flags{"--left-strobe", "GPIO5", "--right-strobe", "none"};
  const auto options = parse_device_options(flags);
  ASSERT_TRUE(options) << refusal(flags);
  const std::array<std::string, 2> lines{"GPIO5", ""};
  EXPECT_EQ(strobe_lines(*options), lines);
  EXPECT_NE(refusal({"--cameras", "libcamera", "--left-strobe", "GPIO5"}).find("leave them out"),
            std::string::npos);
}

TEST(DeviceRequest, SaysWhatAFlagTakes) {
  EXPECT_NE(refusal({"--cameras", "webcam"}).find("v4l2 or libcamera"), std::string::npos);
  for (const char* const size : {"640", "640x", "x480", "640x480x3", "-640x480", "0x0", "1e3x5"}) {
    EXPECT_NE(refusal({"--size", size}).find("WIDTHxHEIGHT"), std::string::npos) << size;
  }
  EXPECT_NE(refusal({"--gain", "-1"}).find("whole number"), std::string::npos);
  EXPECT_NE(refusal({"--priority", "99"}).find("0 (none) to 98"), std::string::npos);
  EXPECT_NE(refusal({"--left"}).find("takes a value"), std::string::npos);
  EXPECT_NE(refusal({"--scene", "hall"}).find("unknown argument"), std::string::npos);
  EXPECT_NE(refusal({"--size", "641x480"}).find("up to 640x480"), std::string::npos);
  EXPECT_NE(refusal({"--pmd-size", "8x145"}).find("up to 176x144"), std::string::npos);
  EXPECT_NE(refusal({"--pmd", "none", "--pmd-size", "8x8"}).find("leave one out"),
            std::string::npos);
}

TEST(NominalRig, ScalesWithThePictures) {
  const dsp::Calibration full = nominal_rig(kConfig, {640, 480}, {176, 144});
  EXPECT_DOUBLE_EQ(full.stereo.left.fx, kConfig.nominal.stereo_focal_px);
  EXPECT_STREQ(dsp::problem(full), "");
  const dsp::Calibration half = nominal_rig(kConfig, {320, 240}, {88, 72});
  EXPECT_DOUBLE_EQ(half.stereo.left.fx * 2, full.stereo.left.fx);
  EXPECT_DOUBLE_EQ(half.stereo.left.cx, 159.5);
  EXPECT_STREQ(dsp::problem(half), "");
  EXPECT_EQ(nominal_rig(kConfig, {320, 240}, {}).pmd.lens.width, 0);
}

}  // namespace
}  // namespace stof::board
