#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "dsp/base/check.h"
#include "lab/pyramid/patch_boxes_body.h"

// start_patch() and slide_patch() of both variants.
namespace stof::dsp::patch_sums_body {

static void check_patch(const PatchPlace& patch) noexcept {
  STOF_CHECK(patch.block_width >= 1 && patch.block_width <= 64 && !patch.candidates.empty());
  const int reach = patch_reach(patch.block_width);
  STOF_CHECK(patch.left_x >= 0 && patch.left_x + reach <= patch.left.width() &&
             patch.right_x >= patch.candidates.back() &&
             patch.right_x - patch.candidates.front() + reach <= patch.right.width());
}

template <typename Isa, std::size_t kBlock>
void Boxes<Isa, kBlock>::slide(int entering, int leaving, std::size_t first, std::size_t count,
                               std::uint16_t* sums) noexcept {
  const std::uint8_t* const in = patch_.left.row_clamped(entering).data() + patch_.left_x;
  const std::uint8_t* const gone = patch_.left.row_clamped(leaving).data() + patch_.left_x;
  const std::uint8_t* met_in[kGroup];
  const std::uint8_t* met_gone[kGroup];
  for (std::size_t i = 0; i < count; ++i) {
    met_in[i] = patch_.right.row_clamped(entering).data() + right_at(first + i);
    met_gone[i] = patch_.right.row_clamped(leaving).data() + right_at(first + i);
  }
  Bytes left[kLine / kBytes];
  Bytes left_gone[kLine / kBytes];
  for (std::size_t k = 0; k < columns(); k += kBytes) {
    left[k / kBytes] = Isa::load_bytes(in + k);
    left_gone[k / kBytes] = Isa::load_bytes(gone + k);
  }
  // All candidates before the next step, each with all its columns: what a step stores is far
  // when the next one loads it, across the bounds of what was stored.
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < columns(); k += kBytes) {
      const Bytes comes = Isa::difference(left[k / kBytes], Isa::load_bytes(met_in[i] + k));
      const Bytes goes = Isa::difference(left_gone[k / kBytes], Isa::load_bytes(met_gone[i] + k));
      Isa::store_bytes(ones_[i] + k, Isa::minus(comes, goes));
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < columns(); k += kBytes) {
      const auto one = [&](std::size_t j) noexcept {
        return Isa::load_bytes(ones_[i] + k + j * kStride);
      };
      Isa::store_bytes(fours_[i] + k,
                       Isa::plus(Isa::plus(one(0), one(1)), Isa::plus(one(2), one(3))));
    }
  }
  if constexpr (kSixteens) {
    for (std::size_t i = 0; i < count; ++i) {
      add_sixteens(i, sums + i * kColumns);
    }
    return;
  }
  for (std::size_t i = 0; i < count; ++i) {
    add_boxes([&](std::size_t x) noexcept { return Isa::widen(fours_[i] + x); },
              [&](std::size_t x) noexcept { return Isa::widen(ones_[i] + x); },
              sums + i * kColumns);
  }
}

// For all candidates, by groups.
template <typename Isa, typename Work>
void with_boxes(const PatchPlace& patch, std::span<std::uint16_t> sums, Work work) noexcept {
  check_patch(patch);
  STOF_CHECK(sums.size() == patch.candidates.size() * kColumns);
  const auto go = [&](auto boxes) noexcept {
    for (std::size_t first = 0; first < patch.candidates.size(); first += kGroup) {
      work(boxes, first, std::min(kGroup, patch.candidates.size() - first),
           sums.data() + first * kColumns);
    }
  };
  if (patch.block_width == 16) {
    go(Boxes<Isa, 16>(patch));
  } else if (patch.block_width == 15) {
    go(Boxes<Isa, 15>(patch));
  } else {
    go(Boxes<Isa, 0>(patch));
  }
}

template <typename Isa>
void start(const PatchPlace& patch, Rows rows, std::span<std::uint16_t> sums) noexcept {
  with_boxes<Isa>(patch, sums,
                  [&](auto& boxes, std::size_t first, std::size_t count,
                      std::uint16_t* to) noexcept { boxes.start(rows, first, count, to); });
}

template <typename Isa>
void slide(const PatchPlace& patch, int entering, int leaving,
           std::span<std::uint16_t> sums) noexcept {
  with_boxes<Isa>(
      patch, sums,
      [&](auto& boxes, std::size_t first, std::size_t count, std::uint16_t* to) noexcept {
        boxes.slide(entering, leaving, first, count, to);
      });
}

}  // namespace stof::dsp::patch_sums_body
