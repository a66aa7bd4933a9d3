#include "dsp/pmd/converter.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "dsp/calib/pmd/emitter_offset_table.h"
#include "dsp/calib/pmd/frequency_pair.h"
#include "dsp/calib/pmd/pmd_tables.h"
#include "dsp/pmd/interval/fill_intervals.h"
#include "dsp/pmd/phase/frame_phases.h"
#include "dsp/pmd/phase/motion_correction.h"
#include "dsp/pmd/range/combine_frequencies.h"
#include "dsp/pmd/range/emitter_offset.h"
#include "dsp/pmd/range/to_quarter_mm.h"
#include "dsp/pmd/reading_memory.h"

namespace stof::dsp {
namespace {

ImageView<QuarterMm> take_padded(Arena& arena, int width, int height) noexcept {
  const std::span<QuarterMm> all = arena.take_filled(pixel_count(width + 2, height), kNoDepth);
  return {all.data() + 1, width, height, width + 2};
}

// Surfaces tilted by up to 60 degrees are no edges.
std::uint16_t slope_of(const Pinhole& lens) noexcept {
  const double two_pixels = 2 * std::numbers::sqrt3 / lens.fx;
  return static_cast<std::uint16_t>(std::clamp(std::round(two_pixels * 65536), 0.0, 65535.0));
}

}  // namespace

// What a second frequency adds.
struct SecondFrequency {
  FrameTables tables;
  FrequencyPair pair;
  RangeTables both;  // of distances that both frequencies tell
  ExposureRow row;
  std::span<Phase> corrected;
};

struct PmdConverter::Tables {
  FrameTables first;
  RangeTables one_frequency;
  std::optional<SecondFrequency> second;
  std::optional<SigmaCurve> curve;    // sigma by distance
  EmitterOffsetTable emitter_offset;  // empty without lights beside the lens
  std::uint32_t shortest_way = 0;
  std::span<const std::int16_t> fixed_pattern;
  MergeRows spare;
  std::span<Phase> corrected;
  std::span<std::uint32_t> reading;        // where no long_distance holds it
  std::optional<MotionCorrection> motion;  // always there
  std::optional<ReadingMemory> memory;

  std::span<const std::int16_t> fixed_pattern_row(int y, std::size_t n) const noexcept {
    return fixed_pattern.empty() ? fixed_pattern : fixed_pattern.subspan(index(y) * n, n);
  }
  EmitterOffsetRow emitter_offset_row(int y, std::size_t n) const noexcept {
    const std::size_t at = index(y) * n;
    return {emitter_offset.half_q2.subspan(at, n), emitter_offset.twice_area.subspan(at, n),
            emitter_offset.pole.subspan(at, n)};
  }
};

PmdConverter::PmdConverter(const PmdSensor& sensor, Arena& arena, bool remembers) noexcept {
  const int w = sensor.lens.width;
  const int h = sensor.lens.height;
  const std::size_t row = index(w);
  Tables t;
  t.first = make_frame_tables(sensor, sensor.frequency);
  t.one_frequency = range_tables(sensor, turn_m(sensor.frequency));
  t.fixed_pattern = sensor.fixed_pattern;
  maps_.slope_q16 = slope_of(sensor.lens);
  t.spare = {take_exposure_row(arena, row), arena.take<std::uint8_t>(row)};
  t.corrected = arena.take<Phase>(row);
  t.reading = arena.take<std::uint32_t>(row);
  if (sensor.sigma_polynomial) {
    t.curve = sigma_curve(*sensor.sigma_polynomial);
  }
  if (sensor.second) {
    const FrequencyPair pair =
        make_frequency_pair(sensor.frequency.modulation, sensor.second->modulation);
    t.second =
        SecondFrequency{.tables = make_frame_tables(sensor, *sensor.second),
                        .pair = pair,
                        .both = range_tables(sensor, common_range(pair) / units_per_metre(sensor)),
                        .row = take_exposure_row(arena, row),
                        .corrected = arena.take<Phase>(row)};
  }
  if (sensor.emitter_count > 0) {
    t.emitter_offset = make_emitter_offset_table(sensor, units_per_metre(sensor), arena);
    t.shortest_way = shortest_way(sensor, units_per_metre(sensor));
  }
  maps_.phase = arena.take_image<Phase>(w, h);
  maps_.amp2 = arena.take_image<std::uint16_t>(w, h);
  maps_.offset = arena.take_image<std::uint16_t>(w, h);
  maps_.flags = arena.take_image<std::uint8_t>(w, h);
  maps_.distance = take_padded(arena, w, h);
  maps_.sigma = take_padded(arena, w, h);
  if (is_fine(sensor.lens)) {
    maps_.smoothed = take_padded(arena, w, h);
    maps_.smoothed_sigma = take_padded(arena, w, h);
  }
  maps_.folded = arena.take_image<QuarterMm>(w, h);
  maps_.folded_sigma = arena.take_image<QuarterMm>(w, h);
  maps_.low = arena.take_image<QuarterMm>(w, h);
  maps_.high = arena.take_image<QuarterMm>(w, h);
  maps_.ratio = arena.take_image<std::uint8_t>(w, h);
  t.motion.emplace(w, h, arena);
  if (remembers) {
    t.memory.emplace(w, h, t.first.frequency.limits.ratio_q16, arena);
  }
  if (has_long_range(sensor)) {
    maps_.long_distance = arena.take_image<std::uint32_t>(w, h);
  }
  tables_ = arena.put(t);
}

void PmdConverter::forget_past() noexcept {
  if (tables_->memory) {
    tables_->memory->forget();
  }
}

ExposureRow PmdConverter::first_row(int y) const noexcept {
  const PmdMaps& m = maps_;
  return {.phase = m.phase.row(y),
          .amp2 = m.amp2.row(y),
          .offset = m.offset.row(y),
          .ratio = m.ratio.row(y),
          .sigma = m.sigma.row(y),
          .flags = m.flags.row(y)};
}

// After measure_phases() of all rows.
void PmdConverter::measure_row(const PmdFrame& frame, int y) noexcept {
  Tables& t = *tables_;
  const PmdMaps& m = maps_;
  const std::size_t n = index(m.phase.width());
  const ExposureRow row = first_row(y);
  const std::span<const std::int16_t> pattern = t.fixed_pattern_row(y, n);
  const std::span<std::uint32_t> reading =
      m.long_distance.empty() ? t.reading : m.long_distance.row(y);
  const std::span<QuarterMm> more_sigma = m.low.row(y);  // intervals come later
  if (m.moved) {
    t.motion->correct(sample_rows(frame.first[0].samples, y), t.first, y, t.spare.shorter, row,
                      more_sigma);
  }
  if (t.memory) {
    t.memory->admit(y, row.ratio, row.offset, row.flags);
  }
  best::correct_phase(row.phase, pattern, t.first.correction, t.corrected);
  const RangeTables* range = &t.one_frequency;
  if (frame.second.empty()) {
    best::phase_to_distance(t.corrected, t.first.frequency.turn, reading);
  } else {
    const SecondFrequency& second = *t.second;
    range = &second.both;
    measure_phases(frame.second, y, second.tables, t.spare, second.row);
    best::correct_phase(second.row.phase, pattern, second.tables.correction, second.corrected);
    best::combine_frequencies({t.corrected, row.amp2, row.sigma},
                              {second.corrected, second.row.amp2, second.row.sigma}, second.pair,
                              second.row.flags, row.flags, reading);
    best::combine_sigma(second.row.sigma, row.sigma);
  }
  if (!changes_nothing(range->line)) {
    best::correct_distance(range->line, reading);
  }
  if (!t.emitter_offset.half_q2.empty()) {
    best::emitter_offset(t.emitter_offset_row(y, n), t.shortest_way, reading);
  }
  best::to_quarter_mm(reading, range->unit_q30, row.flags, m.distance.row(y), row.sigma);
  if (t.curve) {
    best::curve_sigma(m.distance.row(y), *t.curve, row.sigma);
  }
  if (m.moved) {
    t.motion->widen(y, more_sigma, row.sigma);
  }
  if (t.memory) {
    t.memory->settle(y, row.flags, m.distance.row(y), row.sigma);
  }
}

const PmdMaps& PmdConverter::measure(const PmdFrame& frame) noexcept {
  Tables& t = *tables_;
  const int width = maps_.phase.width();
  const int height = maps_.phase.height();
  check_exposures(frame.first, width, height);
  maps_.integration = prepare_frame_tables(frame.first, frame.temperature_q8, t.first);
  const RangeTables* range = &t.one_frequency;
  if (!frame.second.empty()) {
    STOF_CHECK(t.second.has_value());
    check_exposures(frame.second, width, height);
    prepare_frame_tables(frame.second, frame.temperature_q8, t.second->tables);
    range = &t.second->both;
  }
  if (t.memory) {
    t.memory->begin_frame();
  }
  maps_.range = range->range;
  maps_.widest = range->widest;
  for (int y = 0; y < height; ++y) {
    measure_phases(frame.first, y, t.first, t.spare, first_row(y));
  }
  maps_.moved = frame.first.size() == 1 && frame.second.empty() && t.motion->look(maps_.flags);
  for (int y = 0; y < height; ++y) {
    measure_row(frame, y);
    std::ranges::fill(maps_.folded.row(y), kNoDepth);
    std::ranges::fill(maps_.folded_sigma.row(y), QuarterMm{0});
  }
  return maps_;
}

const PmdMaps& PmdConverter::convert(const PmdFrame& frame) noexcept {
  measure(frame);
  refresh_intervals(maps_);
  return maps_;
}

const PmdMaps& PmdConverter::convert(const PmdSamples& samples) noexcept {
  const PmdExposure exposure{.samples = samples};
  return convert(PmdFrame{.first = {&exposure, 1}});
}

}  // namespace stof::dsp
