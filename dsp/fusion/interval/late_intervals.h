#pragma once

#include <cstddef>

namespace stof::dsp {

// Somebody who fills intervals of a row where they are asked for, because few of them are. A
// function and no virtual one, so that it may live in an Arena.
struct LateIntervals {
  // Fills elements begin .. end - 1 of the row, and may fill others; asked again it need not.
  using Tell = void(LateIntervals& self, std::size_t begin, std::size_t end) noexcept;
  Tell* tell = nullptr;
};

}  // namespace stof::dsp
