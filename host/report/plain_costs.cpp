#include "host/report/plain_costs.h"

#include <algorithm>
#include <array>

#include "dsp/base/index.h"
#include "dsp/stereo/cost/census.h"
#include "dsp/stereo/cost/hamming.h"
#include "dsp/stereo/cost/prefilter.h"
#include "dsp/stereo/cost/sad.h"
#include "lab/cost/cost_sums.h"
#include "lab/cost/ssd.h"

namespace stof::host {
namespace {

template <std::size_t kRows>
std::array<std::span<const std::uint8_t>, kRows> window(const dataset::Image<std::uint8_t>& picture,
                                                        int y) {
  std::array<std::span<const std::uint8_t>, kRows> rows;
  for (std::size_t i = 0; i < kRows; ++i) {
    rows[i] = picture.view().row_clamped(y - static_cast<int>(kRows / 2) + static_cast<int>(i));
  }
  return rows;
}

}  // namespace

dataset::Image<std::uint8_t> plain_derivative(const dataset::Image<std::uint8_t>& picture,
                                              int cap) {
  dataset::Image<std::uint8_t> result(picture.width, picture.height);
  const dsp::ImageView<const std::uint8_t> rows = picture.view();
  for (int y = 0; y < picture.height; ++y) {
    dsp::ref::clipped_sobel(rows.row_clamped(y - 1), rows.row(y), rows.row_clamped(y + 1), cap,
                            result.view().row(y));
  }
  return result;
}

template <typename Sum>
PlainCosts<Sum>::PlainCosts(const dataset::StereoScene& scene, const lab::MatchParams& params)
    : params_(params),
      lanes_(dsp::lanes_of(params)),
      columns_(dsp::block_columns(params)),
      widened_(scene.left.width + columns_.before + columns_.after),
      left_(scene.left),
      right_(scene.right) {
  if (params.prefilter_cap) {
    left_ = plain_derivative(left_, *params.prefilter_cap);
    right_ = plain_derivative(right_, *params.prefilter_cap);
  }
  for (RowPair* pair : {&new_, &old_}) {
    pair->left.resize(dsp::index(widened_));
    pair->right.resize(dsp::index(widened_ + lanes_ - 1));
  }
  if (census()) {
    kept_.resize(dsp::index(params.block_height) + 1,
                 std::vector<std::uint8_t>(dsp::index(widened_) * dsp::index(lanes_)));
  }
  sums_.resize(dsp::index(widened_) * dsp::index(lanes_));
  costs_.resize(dsp::index(left_.width) * dsp::index(lanes_));
}

template <typename Sum>
bool PlainCosts<Sum>::census() const {
  return params_.cost == lab::Cost::kCensus5x5 || params_.cost == lab::Cost::kCensus9x7;
}

template <typename Sum>
std::span<const Sum> PlainCosts<Sum>::row(int y) {
  const int above = params_.block_height / 2;
  const int below = params_.block_height - 1 - above;
  if (y == 0) {
    std::ranges::fill(sums_, Sum{0});
    for (int at = -above; at <= below; ++at) {
      enter(at);
    }
  } else {
    exchange(y + below, y - 1 - above);
  }
  dsp::ref::block_sums<Sum>(sums_, params_.block_width, lanes_, costs_);
  mark_outside();
  return costs_;
}

template <typename Sum>
void PlainCosts<Sum>::mark_outside() {
  for (int x = 0; x < left_.width; ++x) {
    for (int i = 0; i < lanes_; ++i) {
      const int right_x = x - params_.min_disparity - i;
      if (i >= params_.disparities || right_x < 0 || right_x >= left_.width) {
        costs_[dsp::index(x * lanes_ + i)] = dsp::kNoCost<Sum>;
      }
    }
  }
}

template <typename Sum>
void PlainCosts<Sum>::load(int y, RowPair& pair) const {
  dsp::extend_row(left_.view().row_clamped(y), columns_, pair.left);
  dsp::reverse_row(right_.view().row_clamped(y), columns_, params_.min_disparity, pair.right);
}

template <typename Sum>
std::vector<std::uint8_t>& PlainCosts<Sum>::kept(int y) {
  // One more than the block's rows: what leaves is still there when the next one enters.
  return kept_[dsp::index(y + params_.block_height) % kept_.size()];
}

template <typename Sum>
void PlainCosts<Sum>::describe(const dataset::Image<std::uint8_t>& picture, int y,
                               std::vector<std::uint8_t>& planes) const {
  if (params_.cost == lab::Cost::kCensus5x5) {
    planes.resize(dsp::planes_of(dsp::kCensus5x5Bits) * dsp::index(picture.width));
    dsp::ref::census_5x5(window<5>(picture, y), planes);
  } else {
    planes.resize(dsp::planes_of(dsp::kCensus9x7Bits) * dsp::index(picture.width));
    dsp::ref::census_9x7(window<7>(picture, y), planes);
  }
}

template <typename Sum>
void PlainCosts<Sum>::pixel_costs(int y, std::vector<std::uint8_t>& costs) const {
  const int inside = std::clamp(y, 0, left_.height - 1);
  const std::size_t width = dsp::index(left_.width);
  const std::size_t left_length = dsp::index(widened_);
  const std::size_t right_length = dsp::index(widened_ + lanes_ - 1);
  std::vector<std::uint8_t> left;
  std::vector<std::uint8_t> right;
  describe(left_, inside, left);
  describe(right_, inside, right);
  const std::size_t planes = left.size() / width;
  std::vector<std::uint8_t> left_row(planes * left_length);
  std::vector<std::uint8_t> right_row(planes * right_length);
  for (std::size_t p = 0; p < planes; ++p) {
    dsp::extend_row(std::span(left).subspan(p * width, width), columns_,
                    std::span(left_row).subspan(p * left_length, left_length));
    dsp::reverse_row(std::span(right).subspan(p * width, width), columns_, params_.min_disparity,
                     std::span(right_row).subspan(p * right_length, right_length));
  }
  const int bits =
      params_.cost == lab::Cost::kCensus5x5 ? dsp::kCensus5x5Bits : dsp::kCensus9x7Bits;
  dsp::ref::hamming_costs(left_row, right_row, bits, lanes_, costs);
}

template <typename Sum>
void PlainCosts<Sum>::enter(int y) {
  if (census()) {
    pixel_costs(y, kept(y));
    dsp::ref::add_costs<Sum>(kept(y), sums_);
    return;
  }
  load(y, new_);
  if (params_.cost == lab::Cost::kSsd) {
    dsp::ref::add_squares<Sum>(new_.left, new_.right, lanes_, sums_);
  } else {
    dsp::ref::add_differences<Sum>(new_.left, new_.right, lanes_, sums_);
  }
}

template <typename Sum>
void PlainCosts<Sum>::exchange(int entering, int leaving) {
  if (census()) {
    pixel_costs(entering, kept(entering));
    dsp::ref::slide_costs<Sum>(kept(entering), kept(leaving), sums_);
    return;
  }
  load(entering, new_);
  load(leaving, old_);
  if (params_.cost == lab::Cost::kSsd) {
    dsp::ref::slide_squares<Sum>(new_.left, new_.right, old_.left, old_.right, lanes_, sums_);
  } else {
    dsp::ref::slide_differences<Sum>(new_.left, new_.right, old_.left, old_.right, lanes_, sums_);
  }
}

template class PlainCosts<std::uint16_t>;
template class PlainCosts<std::uint32_t>;

}  // namespace stof::host
