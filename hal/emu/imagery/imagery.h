#pragma once

#include <cstdint>

#include "dsp/base/image.h"

namespace stof::hal::emu {

struct Size {
  int width = 0;
  int height = 0;
  friend constexpr bool operator==(Size, Size) noexcept = default;
};

// The pictures of an emulated rig's sensors. A pure function of the exposure's number: the same
// number gives the same bits, on every machine, in any order. Allocates nothing.
class Imagery {
 public:
  virtual ~Imagery() = default;
  virtual Size stereo_size() const noexcept = 0;
  virtual Size pmd_size() const noexcept = 0;  // 0x0: this rig has no PMD camera
  // Exposure `number` of one view; `out` has stereo_size().
  virtual void left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept = 0;
  virtual void right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept = 0;
  // Sample A_index, index 0..3, of exposure `number`; `out` has pmd_size().
  virtual void pmd(std::uint32_t number, int index, dsp::ImageView<std::uint16_t> out) noexcept = 0;
};

}  // namespace stof::hal::emu
