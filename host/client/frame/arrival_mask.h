#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/base/image.h"
#include "firmware/wire/packet.h"

namespace stof::client {

// The size of one or more streams' images, and which pixels of them have arrived: a byte a pixel,
// a bit a stream. Keeps its memory from frame to frame.
class ArrivalMask {
 public:
  // Forgets size and marks.
  void begin() noexcept {
    columns_ = 0;
    rows_ = 0;
  }
  bool open() const noexcept { return columns_ != 0 && rows_ != 0; }

  // Takes the packet's image size if there is none yet. False: it is another one, or empty.
  bool fits(const wire::Header& header);

  // Whether none of these pixels has arrived. They lie in the image.
  bool vacant(std::size_t first, std::size_t count, std::uint8_t bit) const noexcept;
  void mark(std::size_t first, std::size_t count, std::uint8_t bit) noexcept;

  std::size_t pixels() const noexcept { return std::size_t{columns_} * rows_; }
  int columns() const noexcept { return columns_; }
  int rows() const noexcept { return rows_; }
  dsp::ImageView<const std::uint8_t> marks() const noexcept {
    return {marks_.data(), columns_, rows_};
  }

  // Sets every pixel to `none` that did not arrive.
  template <typename T>
  void blank(std::vector<T>& image, std::uint8_t bit, const T& none) const noexcept {
    for (std::size_t i = 0; i < pixels(); ++i) {
      if ((marks_[i] & bit) == 0) {
        image[i] = none;
      }
    }
  }

 private:
  std::uint16_t columns_ = 0;
  std::uint16_t rows_ = 0;
  std::vector<std::uint8_t> marks_;
};

}  // namespace stof::client
