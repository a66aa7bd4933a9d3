#include "dsp/pmd/converter.h"

#include <memory>
#include <span>

#include "dsp/base/check.h"
#include "dsp/calib/pmd_tables.h"
#include "dsp/pmd/interval.h"
#include "dsp/pmd/phase.h"
#include "dsp/pmd/range.h"

namespace stof::dsp {
namespace {

std::size_t pixels(int width, int height) noexcept {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

// A row of `width` pixels with its two neighbours outside, which stay missing.
template <typename T>
std::span<T> padded_row(const ImageView<T>& image, int y) noexcept {
  const std::span<T> row = image.row_clamped(y);
  return {row.data() - 1, row.size() + 2};
}

ImageView<QuarterMm> take_padded(Arena& arena, int width, int height) noexcept {
  const std::span<QuarterMm> all = arena.take<QuarterMm>(pixels(width + 2, height));
  for (QuarterMm& value : all) {
    value = kNoDepth;
  }
  return {all.data() + 1, width, height, width + 2};
}

}  // namespace

struct Converter::Tables {
  PhaseLimits limits;
  RangeParams range;
  std::span<const std::int16_t> fixed_pattern;

  std::span<const std::int16_t> fixed_pattern_row(int y, int width) const noexcept {
    const std::size_t n = static_cast<std::size_t>(width);
    return fixed_pattern.empty() ? fixed_pattern
                                 : fixed_pattern.subspan(static_cast<std::size_t>(y) * n, n);
  }
};

std::size_t Converter::bytes_needed(int width, int height) noexcept {
  const std::size_t plain = pixels(width, height);
  return Arena::bytes_for<Tables>(1) + 5 * Arena::bytes_for<std::uint16_t>(plain) +
         Arena::bytes_for<std::uint8_t>(plain) +
         2 * Arena::bytes_for<QuarterMm>(pixels(width + 2, height));
}

Converter::Converter(const PmdSensor& sensor, Arena& arena) noexcept {
  const int w = sensor.lens.width;
  const int h = sensor.lens.height;
  tables_ =
      std::construct_at(arena.take<Tables>(1).data(),
                        Tables{phase_limits(sensor), range_params(sensor), sensor.fixed_pattern});
  maps_.phase = arena.take_image<Phase>(w, h);
  maps_.amp2 = arena.take_image<std::uint16_t>(w, h);
  maps_.offset = arena.take_image<std::uint16_t>(w, h);
  maps_.flags = arena.take_image<std::uint8_t>(w, h);
  maps_.distance = take_padded(arena, w, h);
  maps_.sigma = take_padded(arena, w, h);
  maps_.low = arena.take_image<QuarterMm>(w, h);
  maps_.high = arena.take_image<QuarterMm>(w, h);
}

const PmdMaps& Converter::convert(const PmdSamples& samples) noexcept {
  const PmdMaps& m = maps_;
  const int height = m.phase.height();
  for (const ImageView<const std::uint16_t>& plane : samples) {
    STOF_CHECK(same_size(plane, m.phase));
  }
  for (int y = 0; y < height; ++y) {
    best::phase({samples[0].row(y), samples[1].row(y), samples[2].row(y), samples[3].row(y)},
                tables_->limits, m.phase.row(y), m.amp2.row(y), m.offset.row(y), m.flags.row(y));
    best::range(m.phase.row(y), m.amp2.row(y), m.offset.row(y), m.flags.row(y),
                tables_->fixed_pattern_row(y, m.phase.width()), tables_->range, m.distance.row(y),
                m.sigma.row(y));
  }
  for (int y = 0; y < height; ++y) {
    const IntervalRows rows{padded_row(m.distance, y - 1), padded_row(m.distance, y),
                            padded_row(m.distance, y + 1), padded_row(m.sigma, y - 1),
                            padded_row(m.sigma, y),        padded_row(m.sigma, y + 1)};
    best::interval(rows, tables_->range.range, m.flags.row(y), m.low.row(y), m.high.row(y));
  }
  // Only now, because neighbours were judged by them: a wrapped pixel carries no distance.
  for (int y = 0; y < height; ++y) {
    const std::span<const QuarterMm> high = m.high.row(y);
    const std::span<QuarterMm> distance = m.distance.row(y);
    const std::span<QuarterMm> sigma = m.sigma.row(y);
    for (std::size_t x = 0; x < high.size(); ++x) {
      distance[x] = high[x] == kNoDepth ? kNoDepth : distance[x];
      sigma[x] = high[x] == kNoDepth ? QuarterMm{0} : sigma[x];
    }
  }
  return maps_;
}

}  // namespace stof::dsp
