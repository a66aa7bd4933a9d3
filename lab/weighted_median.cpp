#include "lab/weighted_median.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <span>

#include "dsp/base/check.h"

namespace stof::lab {
namespace {

constexpr int kReach = 2;  // px
constexpr int kWindow = (2 * kReach + 1) * (2 * kReach + 1);
constexpr int kGreyScale = 16;  // grey levels
constexpr int kEvenRaw = 16;    // of Disparity::raw: one px

struct Neighbour {
  int raw;
  int grey;
};

std::array<int, 256> weights() noexcept {
  std::array<int, 256> table;
  for (int difference = 0; difference < 256; ++difference) {
    table[static_cast<std::size_t>(difference)] =
        static_cast<int>(std::lround(4096 * std::exp(-1.0 * difference / kGreyScale)));
  }
  return table;
}

// neighbours: not empty.
int median(std::span<Neighbour> neighbours, int grey, const std::array<int, 256>& table) noexcept {
  std::ranges::sort(neighbours, {}, &Neighbour::raw);
  const auto weight = [&](const Neighbour& one) noexcept {
    return table[static_cast<std::size_t>(std::abs(one.grey - grey))];
  };
  int whole = 0;
  for (const Neighbour& one : neighbours) {
    whole += weight(one);
  }
  int sum = 0;
  for (const Neighbour& one : neighbours) {
    sum += weight(one);
    if (2 * sum >= whole) {
      return one.raw;
    }
  }
  return neighbours.back().raw;
}

}  // namespace

void weighted_median(ImageView<const std::uint8_t> grey, ImageView<const Disparity> in,
                     ImageView<Disparity> out) noexcept {
  STOF_CHECK(same_size(grey, in) && same_size(in, out));
  const std::array<int, 256> table = weights();
  std::array<Neighbour, kWindow> window;
  for (int y = 0; y < in.height(); ++y) {
    const Rows rows{std::max(y - kReach, 0), std::min(y + kReach + 1, in.height())};
    for (int x = 0; x < in.width(); ++x) {
      const Disparity own = in.at(x, y);
      out.at(x, y) = own;
      if (!own.valid()) {
        continue;
      }
      std::size_t count = 0;
      int low = own.raw, high = own.raw;
      for (int yy = rows.begin; yy < rows.end; ++yy) {
        for (int xx = std::max(x - kReach, 0); xx <= std::min(x + kReach, in.width() - 1); ++xx) {
          const Disparity other = in.at(xx, yy);
          if (other.valid()) {
            window[count++] = {other.raw, grey.at(xx, yy)};
            low = std::min<int>(low, other.raw);
            high = std::max<int>(high, other.raw);
          }
        }
      }
      if (high - low >= kEvenRaw) {
        out.at(x, y) = Disparity::from_raw(static_cast<std::int16_t>(
            median(std::span(window).first(count), grey.at(x, y), table)));
      }
    }
  }
}

}  // namespace stof::lab
