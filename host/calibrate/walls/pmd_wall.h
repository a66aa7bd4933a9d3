#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "dataset/dataset.h"

// Recordings of a plane wall at known distances, facing the camera: what a PMD sensor is calibrated
// from.
namespace stof::host {

// Which frames of a recording are used: with half of them a calibration can be judged on the rest.
enum class Frames { kAll, kEven, kOdd };
// "all", "even" or "odd", and back; any other name is kAll.
inline constexpr std::array kFramesNames{"all", "even", "odd"};
const char* to_string(Frames frames) noexcept;
Frames frames_named(std::string_view name) noexcept;
bool chosen(Frames frames, std::size_t frame) noexcept;
Frames others(Frames frames) noexcept;  // of kAll: kAll

struct WallRecording {
  std::string name;
  double z_m = 0;       // of the wall, along the optical axis
  double exposure = 1;  // integration time over the reference integration time
  dataset::PmdRecording recording;
};

// The reading of a pixel in one recording, over the chosen frames. LSB of a sample.
struct Reading {
  double i = 0;            // mean of A0 - A2
  double q = 0;            // mean of A3 - A1
  double level = 0;        // mean of all samples, less dark
  double spread = 0;       // temporal variance of one sample, LSB^2; 0 with a single frame
  double spread_iq = 0;    // of I or Q of one frame
  bool saturated = false;  // a sample of a chosen frame was; the reading is not usable
};

struct Wall {
  std::string name;
  double z_m = 0;
  double exposure = 1;
  int frames = 0;                 // chosen ones
  std::vector<Reading> readings;  // row by row
};

Wall summarise(const WallRecording& recording, Frames frames);

// PREFIX.json of the recordings in a folder, by name, that say how far their wall is ("z_m"). One
// line where the folder cannot be read or a json is none.
dataset::Loaded<std::vector<std::filesystem::path>> list_walls(const std::filesystem::path& folder);

// PREFIX.json, PREFIX_raw.pgm. From the json only what a user knows: size, lens, f_mod_hz,
// dark_lsb, sat_lsb, under_lsb, emitters, z_m, int_scale (1 where absent), integration_us, and the
// rig where it is there. The fixed pattern, wiggling and noise that come with a recording are left
// behind.
dataset::Loaded<WallRecording> read_wall(const std::filesystem::path& prefix);

// Writes what read_wall() reads, into a folder that exists: the recording, with the wall's
// distance.
std::expected<void, dataset::Problem> write_wall(const std::filesystem::path& prefix,
                                                 const WallRecording& wall);

// Empty, or why both cannot be recordings of one camera.
std::string mixed(const WallRecording& a, const WallRecording& b);

// The middle 3/8 by 3/4 of a picture (24x12 of 64x16): what errors are averaged over.
struct Middle {
  int left, top, right, bottom;  // right and bottom outside
  bool holds(int x, int y) const noexcept {
    return x >= left && x < right && y >= top && y < bottom;
  }
};
Middle middle_of(const dsp::Pinhole& lens) noexcept;

}  // namespace stof::host
