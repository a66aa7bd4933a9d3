#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "firmware/program/calibration_installer.h"
#include "firmware/wire/calibration/calibration_file.h"

// A small rig whose calibrations can be told apart, and what is installed on it.
namespace stof::test {

using Bytes = std::vector<std::byte>;

inline constexpr int kPmdWidth = 8;
inline constexpr int kPmdHeight = 6;

// Of baseline `number` mm; its fixed pattern is `number` everywhere.
inline Bytes calibration_file(int number, int width = 64, int height = 48) {
  dsp::Calibration calibration;
  calibration.stereo.left = {
      .width = width, .height = height, .fx = 60, .fy = 60, .cx = 32, .cy = 24};
  calibration.stereo.baseline_m = number / 1000.0;
  calibration.pmd.lens = {
      .width = kPmdWidth, .height = kPmdHeight, .fx = 8, .fy = 8, .cx = 4, .cy = 3};
  const std::vector<std::int16_t> pattern(std::size_t{kPmdWidth} * kPmdHeight,
                                          static_cast<std::int16_t>(number));
  calibration.pmd.fixed_pattern = pattern;
  EXPECT_STREQ(dsp::problem(calibration), "");
  Bytes bytes(wire::calibration_file_bytes(calibration));
  EXPECT_TRUE(wire::encode_calibration_file(calibration, bytes));
  return bytes;
}

// As a start leaves it: with what is in the store, or else the factory's.
inline firmware::RigInfo start_rig(const Bytes& factory, hal::Store* store, bool& unusable) {
  firmware::RigInfo rig;
  rig.needs = {.board = &board::kConfig,
               .left = {.width = 64, .height = 48},
               .pmd = {.width = kPmdWidth, .height = kPmdHeight},
               .modulation = {}};
  rig.factory = factory;
  Bytes file(firmware::most_calibration_bytes(board::kConfig));
  const Result<std::optional<std::size_t>> loaded =
      store == nullptr ? std::optional<std::size_t>() : store->load(file);
  EXPECT_TRUE(loaded);
  rig.installed = loaded && *loaded;
  file.resize(rig.installed ? **loaded : 0);
  const Bytes& used = rig.installed ? file : factory;
  rig.fixed_pattern.resize(firmware::pattern_pixels(board::kConfig));
  std::array<char, 320> space{};
  settings::PagedWriter why(space);
  const auto read = firmware::read_rig_calibration(used, rig.needs, rig.fixed_pattern, why);
  unusable = !read;
  if (read) {
    rig.calibration = *read;
    rig.fingerprint = wire::calibration_fingerprint(used);
  }
  return rig;
}

// Whoever runs with the rig: takes what it says only when it is asked.
class Loop final : public firmware::CalibrationInstaller::Sink {
 public:
  explicit Loop(const firmware::RigInfo& rig) : rig_(rig) {}
  bool rig_in_force() noexcept override { return in_force; }
  wire::SettingsResult takes_rig(settings::PagedWriter& why) noexcept override {
    if (answer != wire::SettingsResult::kOk) {
      why << "no room";
    }
    return answer;
  }
  void use_rig() noexcept override {
    used = rig_.calibration;
    ++uses;
  }

  bool in_force = true;
  wire::SettingsResult answer = wire::SettingsResult::kOk;
  dsp::Calibration used;
  int uses = 0;

 private:
  const firmware::RigInfo& rig_;
};

// One upload of a file, from begin to commit.
inline wire::SettingsResult install(firmware::CalibrationInstaller& installer, const Bytes& file,
                                    std::string& why, hal::Time now) {
  std::array<char, 320> space{};
  settings::PagedWriter line(space);
  wire::SettingsResult result = installer.begin(static_cast<std::uint32_t>(file.size()), line);
  if (result == wire::SettingsResult::kOk) {
    result = installer.write(file, line);
  }
  if (result == wire::SettingsResult::kOk) {
    result = installer.commit({.peer = {}, .now = now, .access = firmware::Access::kAdmin}, line);
  }
  why = line.text();
  return result;
}

}  // namespace stof::test
