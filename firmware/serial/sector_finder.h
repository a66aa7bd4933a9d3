#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/fixed.h"
#include "dsp/calib/pinhole.h"
#include "dsp/fusion/depth_map.h"
#include "firmware/settings/settings.h"
#include "firmware/wire/messages/sectors.h"

// The nearest obstacle by direction, from a depth map with its intervals.
namespace stof::firmware {

inline constexpr int kSectors = 72;
inline constexpr std::uint16_t kUnknownSector = 65'535;

struct SectorParams {
  settings::SectorSettings obstacle{};
  int most_mm = 10'000;  // pixels beyond are not looked at; at most 16,380

  friend bool operator==(const SectorParams&, const SectorParams&) = default;
};

struct Sectors {
  wire::SectorReport report{};
  // The nearest of the sectors within 5 degrees of straight ahead.
  std::uint16_t ahead_cm = kUnknownSector;
  std::uint32_t ahead_sigma_mm = 0;  // standard deviation of the least sure pixel at that distance
};

// Divides the horizontal field of view of the rectified left lens into 72 equal angles.
//
// A pixel with depth stands for the nearest point that its interval allows: Z = depth - width / 2,
// rounded towards the camera. It counts where that point is neither higher nor lower than the
// params say, in the sector of its column, at its horizontal distance sqrt(X^2 + Z^2). A sector's
// distance is that of its `pixels`-th nearest pixel, rounded towards the camera: so many wrong
// pixels less one cannot invent an obstacle, and an obstacle of so many pixels cannot hide. With
// fewer pixels than that the sector is unknown, never free. "Higher" is along the camera's own
// vertical.
class SectorFinder {
 public:
  // lens: of the depth maps, without distortion, 1 pixel or more. At start-up.
  SectorFinder(const dsp::Pinhole& lens, const SectorParams& params, dsp::Arena& arena) noexcept;

  // From the next map on; of the same size.
  void set_lens(const dsp::Pinhole& lens) noexcept;
  // From the next map on.
  void set(const SectorParams& params) noexcept;

  // map.depth and map.width of the lens's size.
  const Sectors& find(const dsp::DepthMap& map) noexcept;

  // The field of the sectors that `ahead` is taken from.
  float ahead_field_rad() const noexcept { return ahead_field_rad_; }
  float vertical_field_rad() const noexcept { return vertical_field_rad_; }

 private:
  // Bins of one centimetre, up to the longest distance of 16,380 mm.
  static constexpr int kBins = 1639;
  static constexpr int kMostPixels = 60'000;
  static constexpr double kAheadDegrees = 5;
  struct Sector {
    int begin = 0;  // columns
    int end = 0;
    int bound = 0;   // bin of the `pixels`-th nearest pixel so far; bins_used_: there is none
    int nearer = 0;  // pixels in the bins below it
  };

  void divide() noexcept;
  void measure_row(std::span<const dsp::QuarterMm> depth, std::span<const dsp::QuarterMm> width,
                   dsp::QuarterMm limit) noexcept;
  void count(Sector& sector, std::span<std::uint16_t> bins, int bin) const noexcept;
  void report(const dsp::DepthMap& map) noexcept;
  std::uint16_t reported_cm(int bound) const noexcept;
  std::uint32_t sigma_mm_at(const dsp::DepthMap& map, int bin) const noexcept;

  dsp::Pinhole lens_;
  SectorParams params_;
  int bins_used_ = kBins;
  std::span<std::uint16_t> stretch_;      // of a column: horizontal distance / Z, Q14, rounded down
  std::span<dsp::QuarterMm> limits_;      // of a row: the furthest Z that is inside the band
  std::span<std::uint16_t> centimetres_;  // of one row's pixels
  std::span<std::uint16_t> bins_;         // kBins of each sector
  std::array<Sector, kSectors> sectors_;
  int first_ahead_ = 0;  // sectors [first, end)
  int end_ahead_ = 0;
  float ahead_field_rad_ = 0;
  float vertical_field_rad_ = 0;
  Sectors found_;
};

}  // namespace stof::firmware
