#include "dsp/stereo/check/speckle.h"

#include <cstdint>
#include <cstdlib>
#include <span>
#include <utility>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

// Patches are sets of runs, a run being connected pixels of one row, named by its first pixel.
// links_ of that pixel is -size of the patch for the run that stands for it, else another run of
// the same patch; links_ of the other pixels are not used. Union by size keeps chains short.
class Patches {
 public:
  Patches(ImageView<const Disparity> disparities, Arena& arena) noexcept
      : disparities_(disparities),
        links_(arena.take_image<std::int32_t>(disparities.width(), disparities.height())) {}

  void find() noexcept {
    for (int y = 0; y < disparities_.height(); ++y) {
      find_runs(y);
      if (y > 0) {
        join_rows(y);
      }
    }
  }

  // The size of the patch of the run that begins at pixel x of row y.
  int size(int x, int y) noexcept { return -link(root(index(x, y))); }

  static bool connected(Disparity a, Disparity b) noexcept {
    return a.valid() && b.valid() && std::abs(a.raw - b.raw) <= Disparity::kOne;
  }

 private:
  std::int32_t index(int x, int y) const noexcept { return y * links_.width() + x; }
  std::int32_t& link(std::int32_t at) noexcept { return links_.data()[at]; }

  void find_runs(int y) noexcept {
    const std::span<const Disparity> row = disparities_.row(y);
    for (std::size_t begin = 0; begin < row.size();) {
      std::size_t end = begin + 1;
      while (end < row.size() && connected(row[end - 1], row[end])) {
        ++end;
      }
      link(index(static_cast<int>(begin), y)) = -static_cast<std::int32_t>(end - begin);
      begin = end;
    }
  }

  void join_rows(int y) noexcept {
    const std::span<const Disparity> above = disparities_.row(y - 1);
    const std::span<const Disparity> row = disparities_.row(y);
    bool joined = false;  // the runs of x - 1 and of the pixel above it are known to be one patch
    std::int32_t run = 0;
    std::int32_t run_above = 0;
    for (std::size_t x = 0; x < row.size(); ++x) {
      const bool begins = x == 0 || !connected(row[x - 1], row[x]);
      const bool begins_above = x == 0 || !connected(above[x - 1], above[x]);
      run = begins ? index(static_cast<int>(x), y) : run;
      run_above = begins_above ? index(static_cast<int>(x), y - 1) : run_above;
      joined = joined && !begins && !begins_above;
      if (!joined && connected(above[x], row[x])) {
        join(root(run_above), root(run));
        joined = true;
      }
    }
  }

  std::int32_t root(std::int32_t at) noexcept {
    while (link(at) >= 0) {
      const std::int32_t next = link(at);
      if (link(next) >= 0) {
        link(at) = link(next);  // half the way is enough next time
      }
      at = next;
    }
    return at;
  }

  void join(std::int32_t a, std::int32_t b) noexcept {
    if (a == b) {
      return;
    }
    if (link(a) > link(b)) {  // sizes are negative: a is the smaller patch
      std::swap(a, b);
    }
    link(a) += link(b);
    link(b) = a;
  }

  ImageView<const Disparity> disparities_;
  ImageView<std::int32_t> links_;
};

}  // namespace

std::size_t drop_speckles_bytes(int width, int height) noexcept {
  return Arena::bytes_for<std::int32_t>(static_cast<std::size_t>(width) *
                                        static_cast<std::size_t>(height));
}

void drop_speckles(ImageView<Disparity> disparities, int min_pixels, Arena arena) noexcept {
  STOF_CHECK(min_pixels >= 0);
  if (disparities.empty() || min_pixels <= 1) {
    return;
  }
  Patches patches(disparities, arena);
  patches.find();
  for (int y = 0; y < disparities.height(); ++y) {
    const std::span<Disparity> row = disparities.row(y);
    Disparity before = Disparity::none();  // of x - 1, as it was
    bool small = false;
    for (std::size_t x = 0; x < row.size(); ++x) {
      if (!Patches::connected(before, row[x])) {
        small = patches.size(static_cast<int>(x), y) < min_pixels;
      }
      before = row[x];
      row[x] = small ? Disparity::none() : row[x];
    }
  }
}

}  // namespace stof::dsp
