#include "firmware/serial/sector_finder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "dsp/base/check.h"

namespace stof::firmware {
namespace {

constexpr int kStretchBits = 14;
constexpr double kMaxStretch = 65'535;
constexpr std::uint32_t kQuarterMmPerCm = 40;
constexpr std::uint32_t kQuarterMmPerMm = 4;
constexpr std::uint16_t kNotCounted = 65'535;  // beyond all bins
constexpr double kDegreesPerRadian = 180 / std::numbers::pi;
constexpr double kMicro = 1e6;

// Direction of a column's middle, radians, clockwise from straight ahead.
double direction(const dsp::Pinhole& lens, double column) noexcept {
  return std::atan((column - lens.cx) / lens.fx);
}

// The near bound's horizontal distance in whole centimetres, down.
constexpr std::uint16_t bin_of(std::uint32_t depth, std::uint32_t width, std::uint32_t stretch,
                               std::uint32_t limit) noexcept {
  const std::uint32_t half = (width + 1) / 2;
  const std::uint32_t near = depth > half ? depth - half : 0;
  const std::uint32_t distance = (near * stretch) >> kStretchBits;  // < 2^18
  return depth == dsp::kNoDepth || near > limit
             ? kNotCounted
             : static_cast<std::uint16_t>(distance / kQuarterMmPerCm);
}

}  // namespace

SectorFinder::SectorFinder(const dsp::Pinhole& lens, const SectorParams& params,
                           dsp::Arena& arena) noexcept
    : lens_(lens),
      stretch_(arena.take<std::uint16_t>(static_cast<std::size_t>(lens.width))),
      limits_(arena.take<dsp::QuarterMm>(static_cast<std::size_t>(lens.height))),
      centimetres_(arena.take<std::uint16_t>(static_cast<std::size_t>(lens.width))),
      bins_(arena.take<std::uint16_t>(std::size_t{kBins} * kSectors)) {
  STOF_CHECK(lens.width > 0 && lens.height > 0 && lens.fx > 0 && lens.fy > 0);
  if (arena.is_measuring()) {
    return;
  }
  set_lens(lens);
  set(params);
}

void SectorFinder::set_lens(const dsp::Pinhole& lens) noexcept {
  STOF_CHECK(lens.width == lens_.width && lens.height == lens_.height);
  lens_ = lens;
  for (std::size_t x = 0; x < stretch_.size(); ++x) {
    const double side = (static_cast<double>(x) - lens.cx) / lens.fx;
    const double stretch = std::floor(std::sqrt(1 + side * side) * (1 << kStretchBits));
    stretch_[x] = static_cast<std::uint16_t>(std::min(stretch, kMaxStretch));
  }
  vertical_field_rad_ = static_cast<float>(std::atan((lens.height - 0.5 - lens.cy) / lens.fy) -
                                           std::atan((-0.5 - lens.cy) / lens.fy));
  divide();
  set(params_);
}

void SectorFinder::divide() noexcept {
  const double left = direction(lens_, -0.5);
  const double step = (direction(lens_, lens_.width - 0.5) - left) / kSectors;
  for (Sector& sector : sectors_) {
    sector = {};
  }
  for (int x = 0; x < lens_.width; ++x) {
    const int index = static_cast<int>((direction(lens_, x) - left) / step);
    Sector& sector = sectors_[static_cast<std::size_t>(std::clamp(index, 0, kSectors - 1))];
    sector.begin = sector.end == 0 ? x : sector.begin;
    sector.end = x + 1;
  }
  // Sectors whose middle lies ahead; at least the one that straight ahead lies in.
  const double reach = kAheadDegrees / kDegreesPerRadian;
  const double first = std::ceil((-reach - left) / step - 0.5);
  const double end = std::floor((reach - left) / step - 0.5) + 1;
  first_ahead_ = static_cast<int>(std::clamp(first, 0.0, kSectors - 1.0));
  end_ahead_ = static_cast<int>(std::clamp(end, first_ahead_ + 1.0, double{kSectors}));
  ahead_field_rad_ = static_cast<float>(step * (end_ahead_ - first_ahead_));
  wire::SectorReport& report = found_.report;
  report.first_udeg =
      static_cast<std::int32_t>(std::lround((left + step / 2) * kDegreesPerRadian * kMicro));
  report.step_udeg = static_cast<std::uint32_t>(std::lround(step * kDegreesPerRadian * kMicro));
}

void SectorFinder::set(const SectorParams& params) noexcept {
  params_ = params;
  settings::SectorSettings& obstacle = params_.obstacle;
  obstacle.pixels = std::clamp(obstacle.pixels, 1, kMostPixels);
  params_.most_mm = std::clamp(params.most_mm, 10, (kBins - 1) * 10);
  obstacle.least_mm = std::clamp(obstacle.least_mm, 0, params_.most_mm);
  bins_used_ = params_.most_mm / 10 + 1;
  found_.report.least_cm = static_cast<std::uint16_t>(obstacle.least_mm / 10);
  found_.report.most_cm = static_cast<std::uint16_t>(params_.most_mm / 10);
  for (std::size_t y = 0; y < limits_.size(); ++y) {
    const double down = (static_cast<double>(y) - lens_.cy) / lens_.fy;
    const double band = down < 0 ? params_.obstacle.above_mm : params_.obstacle.below_mm;
    const double most = dsp::kMaxQuarterMm;
    const double limit = kQuarterMmPerMm * std::max(band, 0.0) / std::abs(down);
    limits_[y] = static_cast<dsp::QuarterMm>(down == 0 ? most : std::min(limit, most));
  }
}

const Sectors& SectorFinder::find(const dsp::DepthMap& map) noexcept {
  STOF_CHECK(map.depth.width() == lens_.width && map.depth.height() == lens_.height &&
             same_size(map.depth, map.width));
  std::ranges::fill(bins_, std::uint16_t{0});
  for (Sector& sector : sectors_) {
    sector.bound = bins_used_;
    sector.nearer = 0;
  }
  // From below: a floor then comes nearest first, and what lies behind needs no counting.
  for (int y = lens_.height - 1; y >= 0; --y) {
    measure_row(map.depth.row(y), map.width.row(y), limits_[static_cast<std::size_t>(y)]);
    for (std::size_t i = 0; i < sectors_.size(); ++i) {
      Sector& sector = sectors_[i];
      for (int x = sector.begin; x < sector.end; ++x) {
        const int bin = centimetres_[static_cast<std::size_t>(x)];
        if (bin < sector.bound) {
          count(sector, bins_.subspan(i * kBins, kBins), bin);
        }
      }
    }
  }
  report(map);
  return found_;
}

// Compilers make vectors of this loop; it has no branches.
void SectorFinder::measure_row(std::span<const dsp::QuarterMm> depth,
                               std::span<const dsp::QuarterMm> width,
                               dsp::QuarterMm limit) noexcept {
  const std::size_t columns = centimetres_.size();
  STOF_CHECK(depth.size() == columns && width.size() == columns && stretch_.size() == columns);
  const dsp::QuarterMm* const depths = depth.data();
  const dsp::QuarterMm* const widths = width.data();
  const std::uint16_t* const stretches = stretch_.data();
  std::uint16_t* const out = centimetres_.data();
  for (std::size_t x = 0; x < columns; ++x) {
    out[x] = bin_of(depths[x], widths[x], stretches[x], limit);
  }
}

// Afterwards fewer than `pixels` are nearer than the bound: whatever lies behind needs no counting.
void SectorFinder::count(Sector& sector, std::span<std::uint16_t> bins, int bin) const noexcept {
  ++bins[static_cast<std::size_t>(bin)];
  ++sector.nearer;
  while (sector.nearer >= params_.obstacle.pixels) {
    --sector.bound;
    sector.nearer -= bins[static_cast<std::size_t>(sector.bound)];
  }
}

void SectorFinder::report(const dsp::DepthMap& map) noexcept {
  wire::SectorReport& report = found_.report;
  int ahead = bins_used_;
  for (int i = 0; i < kSectors; ++i) {
    const int bound = sectors_[static_cast<std::size_t>(i)].bound;
    report.distances_cm[static_cast<std::size_t>(i)] = reported_cm(bound);
    if (i >= first_ahead_ && i < end_ahead_) {
      ahead = std::min(ahead, bound);
    }
  }
  found_.ahead_cm = reported_cm(ahead);
  found_.ahead_sigma_mm = ahead < bins_used_ ? sigma_mm_at(map, ahead) : 0;
}

std::uint16_t SectorFinder::reported_cm(int bound) const noexcept {
  return bound == bins_used_ ? kUnknownSector
                             : std::max(static_cast<std::uint16_t>(bound), found_.report.least_cm);
}

std::uint32_t SectorFinder::sigma_mm_at(const dsp::DepthMap& map, int bin) const noexcept {
  constexpr std::uint32_t kWidthsPerMm = 4 * kQuarterMmPerMm;  // the width is four sigma
  std::uint32_t widest = 0;
  for (int i = first_ahead_; i < end_ahead_; ++i) {
    const Sector& sector = sectors_[static_cast<std::size_t>(i)];
    for (int y = 0; y < lens_.height; ++y) {
      const std::span<const dsp::QuarterMm> depth = map.depth.row(y);
      const std::span<const dsp::QuarterMm> width = map.width.row(y);
      const dsp::QuarterMm limit = limits_[static_cast<std::size_t>(y)];
      for (int x = sector.begin; x < sector.end; ++x) {
        const std::size_t at = static_cast<std::size_t>(x);
        const bool there = bin_of(depth[at], width[at], stretch_[at], limit) == bin;
        widest = std::max<std::uint32_t>(widest, there ? width[at] : 0U);
      }
    }
  }
  return (widest + kWidthsPerMm - 1) / kWidthsPerMm;
}

}  // namespace stof::firmware
