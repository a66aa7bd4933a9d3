#pragma once

#include <cstddef>
#include <cstdint>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/match_params.h"
#include "dsp/stereo/prefilter/equalise.h"

namespace stof::dsp {

// A stereo pair as costs look at it: smoothed, equalised, as a derivative, as MatchParams say.
class PreparedPair {
 public:
  // left_alone: the search compares no derivatives, so that only checks ask for one: that of the
  // left picture. right() is empty then.
  PreparedPair(const MatchParams& params, int width, int height, Arena& arena,
               bool left_alone = false) noexcept;

  // New pictures of equal size, at most the constructor's. They are looked at until the next call.
  void start(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) noexcept;
  // Rows of both pictures; derive() once the rows above and below have gone through filter(). The
  // result of a row does not depend on the split.
  void filter(Rows rows) noexcept;
  void derive(Rows rows) noexcept;
  // Whether they do anything.
  bool filters() const noexcept { return changes_right(params_); }
  bool derives() const noexcept { return params_.prefilter_cap.has_value(); }

  // Grey values, smoothed and equalised where asked for.
  ImageView<const std::uint8_t> left_grey() const noexcept { return left_grey_; }
  ImageView<const std::uint8_t> right_grey() const noexcept { return right_grey_; }
  // The pictures that costs compare: the derivative where there is a prefilter, else grey values.
  ImageView<const std::uint8_t> left() const noexcept;
  ImageView<const std::uint8_t> right() const noexcept;

 private:
  static bool changes_left(const MatchParams& params) noexcept { return params.smooth; }
  static bool changes_right(const MatchParams& params) noexcept {
    return params.smooth || params.equalise;
  }

  MatchParams params_;
  bool left_alone_;
  // Memory; the images of this frame are its upper left parts.
  ImageView<std::uint8_t> left_buffer_;
  ImageView<std::uint8_t> right_buffer_;
  ImageView<std::uint8_t> left_derivative_;
  ImageView<std::uint8_t> right_derivative_;

  ImageView<const std::uint8_t> left_input_;
  ImageView<const std::uint8_t> right_input_;
  ImageView<const std::uint8_t> left_grey_;
  ImageView<const std::uint8_t> right_grey_;
  GreyTable table_{};
};

}  // namespace stof::dsp
