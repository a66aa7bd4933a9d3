#include "dsp/fusion/temporal/past_frames.h"

#include <algorithm>
#include <limits>
#include <span>

namespace stof::dsp {
namespace {

constexpr std::uint8_t kChanged = PictureChange::kPixel | PictureChange::kCell;

}  // namespace

PastFrames::PastFrames(int width, int height, QuarterMm max_range, Arena& arena,
                       int threads) noexcept
    : change_(width, height, arena),
      steady_(width, height, max_range, arena),
      mean_(width, height, TemporalParams{}, arena),
      marks_(arena.take_image<std::uint8_t>(width, threads)),
      causes_(arena.take_filled_image(width, threads, Cause::kNone)) {}

void PastFrames::forget() noexcept {
  change_.forget();
  memory_ = Memory::kNone;
  frames_ = 0;
}

void PastFrames::look(ImageView<const std::uint8_t> left) noexcept {
  if (left.empty()) {
    forget();
    return;
  }
  const bool moves = frames_ == 1;  // or it is the second frame after a gap
  const bool known = memory_ != Memory::kNone;
  if (change_.look(left)) {
    memory_ = known ? Memory::kGoesOn : Memory::kBegins;
    const int before = known ? frames_ : 0;
    frames_ = static_cast<std::uint16_t>(
        std::min<int>(before + 1, std::numeric_limits<std::uint16_t>::max()));
    return;
  }
  memory_ = moves ? Memory::kNone : Memory::kBegins;
  frames_ = 1;
}

void PastFrames::filter(int y, int thread, const SensorIntervals& said,
                        const DepthMap& map) noexcept {
  if (!filters()) {
    return;
  }
  const std::span<std::uint8_t> marks = marks_.row(thread);
  if (memory_ == Memory::kGoesOn) {
    change_.mark(y, marks);
  } else {
    std::ranges::fill(marks, kChanged);
  }
  const std::span<Cause> cause = map.cause.empty() ? causes_.row(thread) : map.cause.row(y);
  steady_.filter(y, marks, said, {map.depth.row(y), map.width.row(y), map.source.row(y), cause});
  mean_.filter(y, marks, map);
}

}  // namespace stof::dsp
