#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "dataset/dataset.h"
#include "host/calibrate/walls/pmd_wall.h"

namespace stof::test {

// PREFIX.json and PREFIX_raw.pgm as a user leaves them in a folder; `more` are further keys.
inline void put_wall(const std::filesystem::path& folder, const host::WallRecording& wall,
                     const std::string& more = "") {
  const dsp::PmdSensor& sensor = wall.recording.calibration.pmd;
  const dsp::Pinhole& lens = sensor.lens;
  std::ofstream(folder / (wall.name + ".json"))
      << R"({"width": )" << lens.width << ", \"height\": " << lens.height
      << ", \"frames\": " << wall.recording.frames.size() << ", \"z_m\": " << wall.z_m
      << ", \"f_mod_hz\": " << sensor.frequency.modulation.value
      << ", \"dark_lsb\": " << sensor.dark_lsb << ", \"sat_lsb\": " << sensor.saturation_lsb
      << ", \"fx\": " << lens.fx << ", \"fy\": " << lens.fy << ", \"cx\": " << lens.cx
      << R"(, "cy": )" << lens.cy << R"(, "lsb_e": 60, "read_e": 0)" << more << "}\n";
  dataset::Image<std::uint16_t> all(
      lens.width, 4 * lens.height * static_cast<int>(wall.recording.frames.size()));
  std::size_t at = 0;
  for (const dataset::Image<std::uint16_t>& frame : wall.recording.frames) {
    for (const std::uint16_t sample : frame.pixels) {
      all.pixels[at++] = sample;
    }
  }
  const auto written = dataset::write_pgm16(folder / (wall.name + "_raw.pgm"), all);
  ASSERT_TRUE(written) << written.error().message;
}

}  // namespace stof::test
