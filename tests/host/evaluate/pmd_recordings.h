#pragma once

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "dsp/calib/pmd/ray_table.h"
#include "tests/host/calibrate/wall_files.h"
#include "tests/host/calibrate/wall_simulator.h"

// Recordings of more than one wall, by the simulated camera of calibrate/.
namespace stof::test {

// The constants of the noise as `record` makes it.
inline std::string noise_of(const SimulatedCamera& camera) {
  return ", \"noise_lsb\": " + std::to_string(camera.noise_lsb) + ", \"min_modulation_ratio\": 0.2";
}

inline void write_map(const std::filesystem::path& file, const SimulatedCamera& camera,
                      const std::vector<double>& metres) {
  constexpr double kPerMetre = 8000;
  dataset::Image<std::uint16_t> map(camera.lens.width, camera.lens.height);
  for (std::size_t i = 0; i < metres.size(); ++i) {
    map.pixels[i] = static_cast<std::uint16_t>(std::lround(metres[i] * kPerMetre));
  }
  ASSERT_TRUE(dataset::write_pgm16(file, map));
}

// Radial distance of a wall at z_m in every pixel.
inline std::vector<double> radial(const SimulatedCamera& camera, double z_m) {
  std::vector<double> out;
  for (int y = 0; y < camera.lens.height; ++y) {
    for (int x = 0; x < camera.lens.width; ++x) {
      out.push_back(z_m / dsp::unit_ray(camera.lens, x, y)[2]);
    }
  }
  return out;
}

struct Board {
  double near_m = 1;
  double far_m = 2.2;
  int column = 16;     // that sees both
  double share = 0.5;  // of it that sees the board, which is to its left
  int frames = 4;
};

// NAME.json with "x_edge_m", samples, r_min, r_med, r_max.
inline void write_edge(const std::filesystem::path& folder, const std::string& name,
                       const SimulatedCamera& camera, const Board& board,
                       const std::string& more = ", \"x_edge_m\": 0.01") {
  host::WallRecording wall = record(camera, board.near_m, board.frames, 1);
  const host::WallRecording behind = record(camera, board.far_m, board.frames, 2);
  wall.name = name;
  const int width = camera.lens.width;
  for (std::size_t n = 0; n < wall.recording.frames.size(); ++n) {
    std::vector<std::uint16_t>& samples = wall.recording.frames[n].pixels;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const int x = static_cast<int>(i) % width;
      const double other = behind.recording.frames[n].pixels[i];
      const double share = x == board.column ? board.share : static_cast<double>(x < board.column);
      samples[i] =
          static_cast<std::uint16_t>(std::lround(share * samples[i] + (1 - share) * other));
    }
  }
  put_wall(folder, wall, noise_of(camera) + more);
  std::vector<double> least = radial(camera, board.near_m);
  std::vector<double> most = radial(camera, board.far_m);
  std::vector<double> middle = least;
  for (std::size_t i = 0; i < least.size(); ++i) {
    const int x = static_cast<int>(i) % width;
    least[i] = x > board.column ? most[i] : least[i];
    most[i] = x < board.column ? least[i] : most[i];
    middle[i] = x < board.column || board.share > 0.5 ? least[i] : most[i];
  }
  write_map(folder / (name + "_r_min.pgm"), camera, least);
  write_map(folder / (name + "_r_med.pgm"), camera, middle);
  write_map(folder / (name + "_r_max.pgm"), camera, most);
}

// A little frame of an ifm camera, all of it at about 1 m: noise is 1000 / amplitude, where
// `inverted` is false.
inline dsp::Pinhole frame_lens() {
  return {.width = 24, .height = 16, .fx = 20, .fy = 20, .cx = 11.5, .cy = 7.5, .k1 = -0.05};
}
inline void write_frame(const std::filesystem::path& folder, bool inverted = false) {
  std::filesystem::create_directories(folder);
  const dsp::Pinhole lens = frame_lens();
  std::ofstream(folder / "info.json")
      << R"({"width": 24, "height": 16, "distance_unit_m": 0.0002, "intrinsics": )"
      << R"({"fx": 20, "fy": 20, "cx": 11.5, "cy": 7.5, "k": [-0.05, 0, 0, 0, 0]}})";
  dataset::Image<std::uint16_t> radial_m(lens.width, lens.height);
  dataset::Image<std::uint16_t> amplitude(lens.width, lens.height);
  dataset::Image<std::uint16_t> noise(lens.width, lens.height);
  for (std::size_t i = 0; i < radial_m.pixels.size(); ++i) {
    radial_m.pixels[i] = static_cast<std::uint16_t>(5000 + 7 * i);
    amplitude.pixels[i] = static_cast<std::uint16_t>(500 + 3 * i);
    noise.pixels[i] = static_cast<std::uint16_t>(inverted ? 10 + i : 30'000 / (10 + i) + 400 - i);
  }
  radial_m.pixels[5] = 0;
  ASSERT_TRUE(dataset::write_pgm16(folder / "radial_distance.pgm", radial_m));
  ASSERT_TRUE(dataset::write_pgm16(folder / "amplitude.pgm", amplitude));
  ASSERT_TRUE(dataset::write_pgm16(folder / "distance_noise.pgm", noise));
}

}  // namespace stof::test
