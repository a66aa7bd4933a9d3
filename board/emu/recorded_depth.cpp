#include "board/emu/recorded_depth.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "firmware/wire/codec/interval_quantiser.h"

namespace stof::board {
namespace {

// A row as it was sent.
class SentRow {
 public:
  SentRow(const dsp::DepthMap& map, const Replay::Sent& sent)
      : map_(map),
        sent_(sent),
        rounds_((sent.depth_rounded || sent.width_rounded) && !map.width.empty()),
        row_(static_cast<std::size_t>(map.depth.width())) {}

  std::span<const std::uint16_t> depth(int y) {
    if (!rounds_ || !sent_.depth_rounded) {
      return map_.depth.row(y);
    }
    const unsigned scale = scale_of(y);
    wire::quantise_depth(map_.depth.row(y), scale, row_);
    return scaled(scale);
  }

  std::span<const std::uint16_t> width(int y) {
    if (!rounds_) {
      return map_.width.row(y);
    }
    const unsigned scale = scale_of(y);
    wire::grow_width(map_.depth.row(y), map_.width.row(y), sent_.depth_rounded ? scale : 0, row_);
    if (!sent_.width_rounded) {
      return row_;
    }
    wire::quantise_width(row_, scale);
    return scaled(scale);
  }

 private:
  unsigned scale_of(int y) {
    const int first = y - y % wire::kQuantiserRows;
    if (first != first_) {
      first_ = first;
      scale_ = wire::quantiser_scale(map_, first);
    }
    return scale_;
  }
  std::span<const std::uint16_t> scaled(unsigned scale) {
    for (std::uint16_t& value : row_) {
      value = static_cast<std::uint16_t>(value << scale);
    }
    return row_;
  }

  const dsp::DepthMap& map_;
  Replay::Sent sent_;
  bool rounds_;
  std::vector<std::uint16_t> row_;
  int first_ = -1;
  unsigned scale_ = 0;
};

template <typename T>
std::span<const T> row_of(const std::vector<T>& image, int y, int width) {
  return std::span(image).subspan(static_cast<std::size_t>(y) * static_cast<std::size_t>(width),
                                  static_cast<std::size_t>(width));
}

}  // namespace

bool comparable(const recording::RecordedFrame& recorded) noexcept {
  return recorded.missing_packets == 0 && recorded.info && !recorded.depth.empty();
}

bool equals_recorded(const dsp::DepthMap& computed, const Replay::Sent& sent,
                     const recording::RecordedFrame& recorded) {
  if (recorded.width != computed.depth.width() || recorded.height != computed.depth.height()) {
    return false;
  }
  SentRow row(computed, sent);
  const int width = recorded.width;
  for (int y = 0; y < recorded.height; ++y) {
    if (!std::ranges::equal(row.depth(y), row_of(recorded.depth, y, width))) {
      return false;
    }
    if (!recorded.interval_width.empty() &&
        !std::ranges::equal(row.width(y), row_of(recorded.interval_width, y, width))) {
      return false;
    }
    if (!recorded.source.empty() &&
        (!std::ranges::equal(computed.source.row(y), row_of(recorded.source, y, width)) ||
         !std::ranges::equal(computed.cause.row(y), row_of(recorded.cause, y, width)))) {
      return false;
    }
  }
  return true;
}

}  // namespace stof::board
