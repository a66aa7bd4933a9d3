#pragma once

#include <algorithm>
#include <cstdint>

#include "hal/emu/imagery/imagery.h"

namespace stof::test {

// Pixels that tell which exposure and which view or sample they are.
class FakeImagery final : public hal::emu::Imagery {
 public:
  static constexpr hal::emu::Size kStereo{7, 3};
  static constexpr hal::emu::Size kPmd{5, 2};

  static constexpr std::uint8_t left_value(std::uint32_t number) {
    return static_cast<std::uint8_t>(2 * number);
  }
  static constexpr std::uint8_t right_value(std::uint32_t number) {
    return static_cast<std::uint8_t>(2 * number + 1);
  }
  static constexpr std::uint16_t pmd_value(std::uint32_t number, int index) {
    return static_cast<std::uint16_t>(number * 4 + static_cast<std::uint32_t>(index));
  }

  hal::emu::Size stereo_size() const noexcept override { return kStereo; }
  hal::emu::Size pmd_size() const noexcept override { return kPmd; }
  void left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override {
    fill(out, left_value(number));
  }
  void right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept override {
    fill(out, right_value(number));
  }
  void pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept override {
    fill(out, pmd_value(number, index));
  }

 private:
  template <typename T>
  static void fill(dsp::ImageView<T> out, T value) noexcept {
    for (int y = 0; y < out.height(); ++y) {
      std::ranges::fill(out.row(y), value);
    }
  }
};

}  // namespace stof::test
