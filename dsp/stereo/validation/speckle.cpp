#include "dsp/stereo/validation/speckle.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

using Word = std::uint64_t;
constexpr std::size_t kWord = 64;  // pixels

constexpr std::size_t words_of(int width) noexcept {
  return (static_cast<std::size_t>(width) + kWord - 1) / kWord;
}
// Elements of a line: a pixel before the first, and whole words.
constexpr std::size_t line_size(int width) noexcept { return 1 + words_of(width) * kWord; }

std::size_t first_of(Word bits) noexcept {
  return static_cast<std::size_t>(std::countr_zero(bits));
}

// One bit for each of 64 pixels, the first lowest, where holds(k) is. In bytes first and without
// branches, so that compilers make vectors of it.
template <typename Holds>
Word bits_where(Holds holds) noexcept {
  constexpr std::size_t kBytes = sizeof(Word);
  std::array<std::array<std::uint8_t, kBytes>, kWord / kBytes> flags;
  std::uint8_t* const flag = flags.front().data();
  for (std::size_t k = 0; k < kWord; ++k) {
    flag[k] = holds(k) ? 1 : 0;
  }
  Word out = 0;
  for (std::size_t byte = 0; byte < flags.size(); ++byte) {
    // Moves the lowest bit of byte k to bit k of the highest byte.
    const Word gathered = std::bit_cast<Word>(flags[byte]) * Word{0x0102040810204080};
    out |= (gathered >> (kWord - kBytes)) << (kBytes * byte);
  }
  return out;
}

bool near(std::int16_t a, std::int16_t b) noexcept {
  return static_cast<std::uint16_t>(std::max(a, b) - std::min(a, b)) <= Disparity::kOne;
}

// The line of a scratch, of the width at hand.
struct Line : SpeckleScratch::Line {
  Line(const SpeckleScratch::Line& widest, int width) noexcept
      : SpeckleScratch::Line{
            widest.raw.first(line_size(width)), widest.valid.first(words_of(width)),
            widest.begins.first(words_of(width)), widest.runs.first(words_of(width))} {
    std::ranges::fill(raw, Disparity::none().raw);
    std::ranges::fill(valid, Word{0});
  }

  const std::int16_t* pixels(std::size_t word) const noexcept {
    return raw.data() + 1 + word * kWord;
  }
  // The run of pixel `bit` of a word.
  std::int32_t run(std::size_t word, std::size_t bit) const noexcept {
    return runs[word] + std::popcount(begins[word] << (kWord - 1 - bit)) - 1;
  }

  // Reads a row and finds its runs.
  void read(std::span<const Disparity> row) const noexcept {
    for (std::size_t x = 0; x < row.size(); ++x) {
      raw[x + 1] = row[x].raw;
    }
    Word before = 0;  // whether the last pixel was valid
    for (std::size_t word = 0; word < valid.size(); ++word) {
      const std::int16_t* const p = pixels(word);
      const std::int16_t* const left = p - 1;
      const Word some = bits_where([p](std::size_t k) { return p[k] != Disparity::none().raw; });
      const Word like_left = bits_where([p, left](std::size_t k) { return near(p[k], left[k]); });
      valid[word] = some;
      begins[word] = some & ~(like_left & (some << 1U | before));
      before = some >> (kWord - 1);
    }
  }

  // Calls use(begin, end) for all runs.
  template <typename Use>
  void each_run(Use use) const noexcept {
    std::size_t begin = 0;
    bool open = false;  // a run that began in a word before
    for (std::size_t word = 0; word < valid.size(); ++word) {
      // Behind a run there is a run that begins or a pixel that is not valid.
      const Word starts = begins[word];
      const Word before = valid[word] << 1U | (open ? 1U : 0U);
      const Word stops = (~valid[word] | starts) & before;
      Word events = starts | stops;
      for (; events != 0; events &= events - 1) {
        const std::size_t bit = first_of(events);
        const std::size_t x = word * kWord + bit;
        if ((stops >> bit) % 2 != 0) {
          use(begin, x);
        }
        begin = (starts >> bit) % 2 != 0 ? x : begin;
      }
      open = valid[word] >> (kWord - 1) != 0;
    }
    if (open) {
      use(begin, valid.size() * kWord);
    }
  }
};

// Patches are sets of runs. links_ of a run is -size of the patch for the run that stands for it,
// else another run of the same patch. Union by size keeps chains short.
class Patches {
 public:
  Patches(ImageView<const Disparity> disparities, SpeckleScratch& scratch) noexcept
      : disparities_(disparities),
        links_(scratch.links),
        line_(scratch.lines[0], disparities.width()),
        above_(scratch.lines[1], disparities.width()) {}

  void find() noexcept {
    std::int32_t count = 0;
    for (int y = 0; y < disparities_.height(); ++y) {
      std::swap(line_, above_);
      line_.read(disparities_.row(y));
      std::int32_t next = count;
      line_.each_run([&](std::size_t begin, std::size_t end) noexcept {
        link(next++) = -static_cast<std::int32_t>(end - begin);
      });
      for (std::size_t word = 0; word < line_.begins.size(); ++word) {
        line_.runs[word] = count;
        count += std::popcount(line_.begins[word]);
      }
      join_rows();
    }
  }

  // Calls drop(y, begin, end) for the runs of patches of fewer than min_pixels pixels.
  template <typename Drop>
  void each_small(int min_pixels, Drop drop) noexcept {
    std::int32_t run = 0;
    for (int y = 0; y < disparities_.height(); ++y) {
      line_.read(disparities_.row(y));
      line_.each_run([&](std::size_t begin, std::size_t end) noexcept {
        if (-link(root(run++)) < min_pixels) {
          drop(y, begin, end);
        }
      });
    }
  }

 private:
  std::int32_t& link(std::int32_t run) noexcept { return links_[static_cast<std::size_t>(run)]; }

  // Once where a run first touches one above it, and again where either is another than before.
  void join_rows() noexcept {
    Word last = 0;  // whether the last pixel touched the one above
    for (std::size_t word = 0; word < line_.valid.size(); ++word) {
      const std::int16_t* const here = line_.pixels(word);
      const std::int16_t* const there = above_.pixels(word);
      const Word alike = bits_where([=](std::size_t k) { return near(here[k], there[k]); });
      const Word touching = alike & line_.valid[word] & above_.valid[word];
      const Word again = (touching << 1U | last) & ~line_.begins[word] & ~above_.begins[word];
      for (Word first = touching & ~again; first != 0; first &= first - 1) {
        const std::size_t bit = first_of(first);
        join(root(above_.run(word, bit)), root(line_.run(word, bit)));
      }
      last = touching >> (kWord - 1);
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
  std::span<std::int32_t> links_;
  Line line_;
  Line above_;
};

}  // namespace

SpeckleScratch::SpeckleScratch(int width, int height, Arena& arena) noexcept
    : links(arena.take_passing<std::int32_t>(static_cast<std::size_t>(width) *
                                             static_cast<std::size_t>(height))) {
  for (Line& line : lines) {
    line = {.raw = arena.take_passing<std::int16_t>(line_size(width)),
            .valid = arena.take_passing<Word>(words_of(width)),
            .begins = arena.take_passing<Word>(words_of(width)),
            .runs = arena.take_passing<std::int32_t>(words_of(width))};
  }
}

void drop_speckles(ImageView<Disparity> disparities, int min_pixels,
                   SpeckleScratch& scratch) noexcept {
  STOF_CHECK(min_pixels >= 0);
  if (disparities.empty() || min_pixels <= 1) {
    return;
  }
  Patches patches(disparities, scratch);
  patches.find();
  patches.each_small(min_pixels, [&](int y, std::size_t begin, std::size_t end) noexcept {
    std::ranges::fill(disparities.row(y).subspan(begin, end - begin), Disparity::none());
  });
}

}  // namespace stof::dsp
