#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"

namespace stof::dsp {

// By how much a picture's content moved as a whole, px: to the right, and down.
struct Shift {
  double x = 0;
  double y = 0;
};

// How far the content of one picture moved to the next, as a camera that turns moves it, from two
// profiles: the means of all columns, and of all rows (as RatSLAM's visual odometry has them,
// Milford & Wyeth 2008). The shift is that at which the slopes of both profiles differ least, in
// whole pixels and then a fraction. A pixel or two is what it is good for: things at several
// distances move by several shifts when a camera drives, and its turn about its axis is not told.
// 4 bytes a column and a row.
class PictureShift {
 public:
  // Shifts of up to this share of the picture's width are found: 5 degrees of a lens of 55.
  static constexpr int kReachShare = 11;

  PictureShift() noexcept = default;
  PictureShift(int width, int height, Arena& arena) noexcept;

  // The next picture, of this size. Nothing where there is none before it, or where no shift is
  // much better than the others. 0 where less than a quarter of a pixel is seen.
  std::optional<Shift> look(ImageView<const std::uint8_t> picture) noexcept;
  // The next picture has none before it.
  void forget() noexcept { knows_ = false; }

 private:
  struct Profile {
    std::span<std::uint16_t> now;
    std::span<std::uint16_t> before;
  };

  Profile columns_;
  Profile rows_;
  bool knows_ = false;
};

}  // namespace stof::dsp
