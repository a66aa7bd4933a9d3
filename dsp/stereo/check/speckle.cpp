#include "dsp/stereo/check/speckle.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <utility>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

bool connected(Disparity a, Disparity b) noexcept {
  return std::abs(a.raw - b.raw) <= Disparity::kOne;
}

// Connected pixels of one row, all valid.
struct Run {
  int begin = 0;
  int end = 0;
};

// The first run of the row that begins at x or later; empty at the row's end when there is none.
Run next_run(std::span<const Disparity> row, int x) noexcept {
  const int width = static_cast<int>(row.size());
  const Disparity* const pixels = row.data();
  while (x < width && !pixels[x].valid()) {
    ++x;
  }
  Run run{x, std::min(x + 1, width)};
  while (run.end < width && pixels[run.end].valid() &&
         connected(pixels[run.end - 1], pixels[run.end])) {
    ++run.end;
  }
  return run;
}

// Patches are sets of runs, a run being named by its first pixel. links_ of that pixel is -size of
// the patch for the run that stands for it, else another run of the same patch; links_ of the other
// pixels are not used. Union by size keeps chains short.
class Patches {
 public:
  Patches(ImageView<const Disparity> disparities, Arena& arena) noexcept
      : disparities_(disparities),
        links_(arena.take_image<std::int32_t>(disparities.width(), disparities.height())),
        runs_(arena.take<Run>(row_size())),
        runs_above_(arena.take<Run>(row_size())) {}

  void find() noexcept {
    for (int y = 0; y < disparities_.height(); ++y) {
      std::swap(runs_, runs_above_);
      count_above_ = count_;
      find_runs(y);
      if (y > 0) {
        join_rows(y);
      }
    }
  }

  // The size of the patch of the run that begins at pixel x of row y.
  int size(int x, int y) noexcept { return -link(root(index(x, y))); }

 private:
  std::size_t row_size() const noexcept { return static_cast<std::size_t>(disparities_.width()); }
  std::int32_t index(int x, int y) const noexcept { return y * links_.width() + x; }
  std::int32_t& link(std::int32_t at) noexcept { return links_.data()[at]; }

  void find_runs(int y) noexcept {
    const std::span<const Disparity> row = disparities_.row(y);
    count_ = 0;
    for (Run run = next_run(row, 0); run.begin < run.end; run = next_run(row, run.end)) {
      link(index(run.begin, y)) = run.begin - run.end;
      runs_[count_++] = run;
    }
  }

  void join_rows(int y) noexcept {
    const Disparity* const above = disparities_.row(y - 1).data();
    const Disparity* const here = disparities_.row(y).data();
    std::size_t i = 0;
    std::size_t k = 0;
    while (i < count_above_ && k < count_) {
      const Run a = runs_above_[i];
      const Run b = runs_[k];
      const int end = std::min(a.end, b.end);
      int x = std::max(a.begin, b.begin);
      while (x < end && !connected(above[x], here[x])) {
        ++x;
      }
      if (x < end) {
        join(root(index(a.begin, y - 1)), root(index(b.begin, y)));
      }
      i += a.end == end ? 1 : 0;
      k += b.end == end ? 1 : 0;
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
  std::span<Run> runs_;  // of the row, and of the one above it
  std::span<Run> runs_above_;
  std::size_t count_ = 0;
  std::size_t count_above_ = 0;
};

}  // namespace

std::size_t drop_speckles_bytes(int width, int height) noexcept {
  const auto row = static_cast<std::size_t>(width);
  return Arena::bytes_for<std::int32_t>(row * static_cast<std::size_t>(height)) +
         2 * Arena::bytes_for<Run>(row);
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
    for (Run run = next_run(row, 0); run.begin < run.end; run = next_run(row, run.end)) {
      if (patches.size(run.begin, y) < min_pixels) {
        std::fill(row.begin() + run.begin, row.begin() + run.end, Disparity::none());
      }
    }
  }
}

}  // namespace stof::dsp
