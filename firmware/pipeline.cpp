#include "firmware/pipeline.h"

#include <algorithm>

namespace stof::firmware {
namespace {

std::optional<dsp::Rectifier> make_rectifier(const Setup& setup, dsp::Arena& arena) noexcept {
  if (!setup.calibration.stereo.raw) {
    return std::nullopt;
  }
  return std::optional<dsp::Rectifier>(std::in_place, setup.calibration.stereo, arena);
}

std::optional<dsp::Converter> make_converter(const Setup& setup, dsp::Arena& arena) noexcept {
  if (!setup.has_pmd()) {
    return std::nullopt;
  }
  return std::optional<dsp::Converter>(std::in_place, setup.calibration.pmd, arena);
}

void count_sources(dsp::ImageView<const dsp::Source> source,
                   std::array<std::uint32_t, kSources>& counts) noexcept {
  counts.fill(0);
  for (int y = 0; y < source.height(); ++y) {
    const auto row = source.row(y);
    for (std::size_t kind = 0; kind < kSources; ++kind) {
      counts[kind] +=
          static_cast<std::uint32_t>(std::ranges::count(row, static_cast<dsp::Source>(kind)));
    }
  }
}

}  // namespace

std::size_t Pipeline::bytes_needed(const Setup& setup) noexcept {
  const dsp::Pinhole& left = setup.calibration.stereo.left;
  const dsp::Pinhole& pmd = setup.calibration.pmd.lens;
  const std::size_t pixels =
      static_cast<std::size_t>(left.width) * static_cast<std::size_t>(left.height);
  return (setup.calibration.stereo.raw ? dsp::Rectifier::bytes_needed(left.width, left.height)
                                       : 0) +
         dsp::Matcher::bytes_needed(setup.match, left.width, left.height) +
         (setup.has_pmd() ? dsp::Converter::bytes_needed(pmd.width, pmd.height) : 0) +
         dsp::Fuser::bytes_needed(left.width, left.height, setup.match.disparities, pmd.width,
                                  pmd.height) +
         dsp::Arena::bytes_for<dsp::Disparity>(pixels) +
         2 * dsp::Arena::bytes_for<dsp::QuarterMm>(pixels) +
         dsp::Arena::bytes_for<dsp::Source>(pixels) + dsp::Arena::bytes_for<dsp::Cause>(pixels);
}

Pipeline::Pipeline(const Setup& setup, hal::Clock& clock, dsp::Arena& arena) noexcept
    : clock_(clock),
      rectifier_(make_rectifier(setup, arena)),
      matcher_(setup.match, setup.calibration.stereo.left.width,
               setup.calibration.stereo.left.height, arena),
      converter_(make_converter(setup, arena)),
      fuser_(setup.calibration, setup.fusion, setup.match.min_disparity, setup.match.disparities,
             setup.calibration.stereo.left.width, setup.calibration.stereo.left.height, arena) {
  const int width = setup.calibration.stereo.left.width;
  const int height = setup.calibration.stereo.left.height;
  disparity_ = arena.take_image<dsp::Disparity>(width, height);
  output_.map.depth = arena.take_image<dsp::QuarterMm>(width, height);
  output_.map.width = arena.take_image<dsp::QuarterMm>(width, height);
  output_.map.source = arena.take_image<dsp::Source>(width, height);
  output_.map.cause = arena.take_image<dsp::Cause>(width, height);
}

void Pipeline::match(const hal::StereoFrame& frame) noexcept {
  if (!rectifier_) {
    matcher_.match(frame.left, frame.right, disparity_);
    return;
  }
  rectifier_->rectify(frame.left, frame.right, disparity_.rows());
  // In steps: what looks at the whole map must not see what lies beyond the border.
  const dsp::Rows rows = disparity_.rows();
  matcher_.start(rectifier_->left(), rectifier_->right());
  matcher_.filter(rows);
  matcher_.derive(rows);
  matcher_.match_rows(rows, disparity_);
  rectifier_->clear_border(rows, disparity_);
  matcher_.finish(disparity_);
  rectifier_->clear_border(rows, disparity_);
}

const Output& Pipeline::compute(const Shot& shot) noexcept {
  Stats& stats = output_.stats;
  const hal::Time start = clock_.now();
  match(*shot.stereo);
  const hal::Time matched = clock_.now();
  if (converter_ && shot.pmd) {
    pmd_ = &converter_->convert((*shot.pmd)->samples);
  }
  const hal::Time converted = clock_.now();
  fuser_.fuse({disparity_, matcher_.ratio(), matcher_.weak()}, pmd_, output_.map);
  stats.match = matched - start;
  stats.convert = converted - matched;
  stats.fuse = clock_.now() - converted;
  count_sources(output_.map.source, stats.sources);
  return output_;
}

}  // namespace stof::firmware
