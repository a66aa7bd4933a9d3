#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "firmware/pipeline/pipeline.h"
#include "hal/emu/cameras/trigger.h"
#include "hal/emu/imagery/imagery.h"
#include "hal/time.h"

// What stands before the emulated cameras, and what they saw: the truth that frames are judged by.
namespace stof::campaign {

namespace emu = hal::emu;

// A rig's sizes and the wall's nearest and farthest places.
struct RigSize {
  int width = 32;
  int height = 24;
  int pmd_width = 16;
  int pmd_height = 12;
  double focal = 40;  // px
  double baseline_m = 0.1;
  int first_disparity = 1;  // of the farthest wall
  int disparities = 8;
  std::size_t shown_later = 0;  // the wall of edge n + this is what edge n shows

  // Every edge shows a wall at its own distance, with its own texture: an edge and the six before
  // it differ.
  int disparity(std::size_t edge) const noexcept {
    return first_disparity + static_cast<int>((edge + shown_later) * 3 % 7);
  }
  double depth_m(std::size_t edge) const noexcept { return focal * baseline_m / disparity(edge); }
};

inline constexpr RigSize kSmallRig{};
inline constexpr RigSize kSoakRig{.width = 160,
                                  .height = 120,
                                  .pmd_width = 64,
                                  .pmd_height = 16,
                                  .focal = 200,
                                  .first_disparity = 5,
                                  .disparities = 16};

firmware::Setup setup_of(const RigSize& size);

// Writes down the edges that the cameras saw. No heap while it has room.
class EdgeLog final : public emu::EdgeListener {
 public:
  explicit EdgeLog(std::size_t room) { edges_.reserve(room); }
  void on_edge(hal::Time edge) noexcept override;
  // The number of the edge at that time; `count()` where the cameras saw none.
  std::size_t find(hal::Time edge) const noexcept;
  std::size_t count() const noexcept { return edges_.size(); }
  hal::Time at(std::size_t number) const noexcept { return edges_[number]; }

 private:
  std::vector<hal::Time> edges_;  // ascending
};

// Pixels are painted where they are fetched.
class NoImagery final : public emu::Imagery {
 public:
  explicit NoImagery(const RigSize& size) noexcept : size_(size) {}
  emu::Size stereo_size() const noexcept override { return {size_.width, size_.height}; }
  emu::Size pmd_size() const noexcept override { return {size_.pmd_width, size_.pmd_height}; }
  void left(std::uint32_t, dsp::ImageView<std::uint8_t>) noexcept override {}
  void right(std::uint32_t, dsp::ImageView<std::uint8_t>) noexcept override {}
  void pmd(std::uint32_t, int, dsp::ImageView<std::uint16_t>) noexcept override {}

 private:
  RigSize size_;
};

// shift: 0 for the left view, the wall's disparity for the right one.
void paint_view(dsp::ImageView<std::uint8_t> out, std::size_t edge, int shift) noexcept;
// Sample k of a wall at that distance.
void paint_sample(dsp::ImageView<std::uint16_t> out, double depth_m, int k,
                  const dsp::Pinhole& lens) noexcept;
// Sample of a camera whose lamp is dark.
void paint_dark(dsp::ImageView<std::uint16_t> out, std::size_t seed) noexcept;

}  // namespace stof::campaign
