#include "host/client/frame/arrival_mask.h"

#include <algorithm>

namespace stof::client {

bool ArrivalMask::fits(const wire::Header& header) {
  if (!open()) {
    columns_ = header.image_width;
    rows_ = header.image_height;
    marks_.assign(pixels(), 0);
  }
  return open() && header.image_width == columns_ && header.image_height == rows_;
}

bool ArrivalMask::vacant(std::size_t first, std::size_t count, std::uint8_t bit) const noexcept {
  std::uint8_t seen = 0;
  for (const std::uint8_t mark : std::span(marks_).subspan(first, count)) {
    seen |= mark;
  }
  return (seen & bit) == 0;
}

void ArrivalMask::mark(std::size_t first, std::size_t count, std::uint8_t bit) noexcept {
  for (std::uint8_t& mark : std::span(marks_).subspan(first, count)) {
    mark |= bit;
  }
}

}  // namespace stof::client
