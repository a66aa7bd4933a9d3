#include "dsp/stereo/prepared_pair.h"

#include <algorithm>
#include <cstdlib>
#include <span>

#include "dsp/base/check.h"
#include "dsp/base/target.h"
#include "dsp/stereo/prefilter/prefilter.h"
#include "dsp/stereo/prefilter/smooth.h"

namespace stof::dsp {
namespace {

// The part of `buffer` that has the size of `picture`.
ImageView<std::uint8_t> cut(ImageView<std::uint8_t> buffer,
                            ImageView<const std::uint8_t> picture) noexcept {
  return {buffer.data(), picture.width(), picture.height(), buffer.stride()};
}

// What both cameras see of surfaces in the middle of the search range: elsewhere pictures differ by
// what is in them, not by their exposure.
struct Overlap {
  ImageView<const std::uint8_t> left;
  ImageView<const std::uint8_t> right;
};

Overlap overlap_of(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right,
                   const MatchParams& params) noexcept {
  const int half = left.width() / 2;
  const int shift = std::clamp(params.min_disparity + params.disparities / 2, -half, half);
  const auto from = [&](ImageView<const std::uint8_t> picture, int x) noexcept {
    return ImageView<const std::uint8_t>(picture.data() + x, picture.width() - std::abs(shift),
                                         picture.height(), picture.stride());
  };
  return {from(left, std::max(shift, 0)), from(right, std::max(-shift, 0))};
}

void smooth_rows(ImageView<const std::uint8_t> in, Rows rows,
                 ImageView<std::uint8_t> out) noexcept {
  for (int y = rows.begin; y < rows.end; ++y) {
    best::binomial(in.row_clamped(y - 1), in.row(y), in.row_clamped(y + 1), out.row(y));
  }
}

void derive_rows(ImageView<const std::uint8_t> in, Rows rows, int cap,
                 ImageView<std::uint8_t> out) noexcept {
  for (int y = rows.begin; y < rows.end; ++y) {
    best::clipped_sobel(in.row_clamped(y - 1), in.row(y), in.row_clamped(y + 1), cap, out.row(y));
  }
}

}  // namespace

PreparedPair::PreparedPair(const MatchParams& params, int width, int height, Arena& arena,
                           bool left_alone) noexcept
    : params_(params), left_alone_(left_alone && params.prefilter_cap.has_value()) {
  if (changes_left(params)) {
    left_buffer_ = arena.take_passing_image<std::uint8_t>(width, height);
  }
  if (changes_right(params)) {
    right_buffer_ = arena.take_passing_image<std::uint8_t>(width, height);
  }
  if (params.prefilter_cap) {
    left_derivative_ = arena.take_passing_image<std::uint8_t>(width, height);
    if (!left_alone_) {
      right_derivative_ = arena.take_passing_image<std::uint8_t>(width, height);
    }
  }
}

void PreparedPair::start(ImageView<const std::uint8_t> left,
                         ImageView<const std::uint8_t> right) noexcept {
  STOF_CHECK(same_size(left, right));
  left_input_ = left;
  right_input_ = right;
  left_grey_ = changes_left(params_) ? cut(left_buffer_, left) : left;
  right_grey_ = changes_right(params_) ? cut(right_buffer_, right) : right;
  if (params_.equalise) {
    const Overlap overlap = overlap_of(left, right, params_);
    table_ = equalising_table(overlap.right, overlap.left);
  }
}

void PreparedPair::filter(Rows rows) noexcept {
  if (params_.smooth) {
    smooth_rows(left_input_, rows, cut(left_buffer_, left_input_));
    smooth_rows(right_input_, rows, cut(right_buffer_, right_input_));
  }
  if (params_.equalise) {
    apply_table(table_, params_.smooth ? right_grey_ : right_input_, rows,
                cut(right_buffer_, right_input_));
  }
}

void PreparedPair::derive(Rows rows) noexcept {
  if (params_.prefilter_cap) {
    derive_rows(left_grey_, rows, *params_.prefilter_cap, cut(left_derivative_, left_input_));
    if (!left_alone_) {
      derive_rows(right_grey_, rows, *params_.prefilter_cap, cut(right_derivative_, right_input_));
    }
  }
}

ImageView<const std::uint8_t> PreparedPair::left() const noexcept {
  return params_.prefilter_cap ? cut(left_derivative_, left_input_) : left_grey_;
}

ImageView<const std::uint8_t> PreparedPair::right() const noexcept {
  if (left_alone_) {
    return {};
  }
  return params_.prefilter_cap ? cut(right_derivative_, right_input_) : right_grey_;
}

}  // namespace stof::dsp
