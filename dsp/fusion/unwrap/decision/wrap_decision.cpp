#include "dsp/fusion/unwrap/decision/wrap_decision.h"

#include <algorithm>
#include <cstdlib>
#include <span>

#include "dsp/base/index.h"

namespace stof::dsp {
namespace {

// What distances of one surface may differ by in any case, quarter mm.
constexpr int kLeastNoise = 32;
// Noise of a turn / this blurs every edge: it joins nothing and parts nothing.
constexpr int kClear = 8;

// How each reading goes on in the one opposite. Without branches, in 32 bits, so that compilers
// make vectors of it.
void link_row(std::span<const Reading> from, std::span<const Reading> to,
              std::span<const std::int32_t> slants, int turn,
              std::span<SurfaceLink> links) noexcept {
  constexpr std::int32_t kMostAmplitude = 1 << 21;
  constexpr int kMostSigma = 4095;  // beyond it all is blurred
  const int turn_q16 = (256 << 16) / turn;
  for (std::size_t i = 0; i < from.size(); ++i) {
    const int sigma_a = std::min<int>(from[i].sigma, kMostSigma);
    const int sigma_b = std::min<int>(to[i].sigma, kMostSigma);
    const int noise = 2 * (sigma_a + sigma_b) + kLeastNoise;
    const int far = to[i].distance - from[i].distance;
    const int gain = (far < -turn / 2 ? 1 : 0) - (far > turn / 2 ? 1 : 0);
    const int apart = std::abs(far + gain * turn);
    const int a = static_cast<int>(std::min<std::uint32_t>(from[i].amp2, kMostAmplitude));
    const int b = static_cast<int>(std::min<std::uint32_t>(to[i].amp2, kMostAmplitude));
    const int brighter = std::max(a, b);
    const int darker = std::min(a, b);
    // A fifth, and two sigma: an amplitude's is 2 pi sigma / turn of it. In 1/256.
    const int alike = std::min(51 + ((13 * std::max(sigma_a, sigma_b) * turn_q16) >> 16U), 256);
    const int dimmed = brighter <= 2 * darker ? int{kDimmed} : int{kBroken};
    const int close = (brighter - darker) * 256 <= brighter * alike ? gain : dimmed;
    int link = apart <= noise + slants[i] ? dimmed : int{kBroken};
    link = apart <= noise ? close : link;
    link = noise > turn / kClear ? int{kBlurred} : link;
    link = from[i].distance == kNoDepth ? int{kBroken} : link;
    link = to[i].distance == kNoDepth ? int{kBroken} : link;
    links[i] = static_cast<SurfaceLink>(link);
  }
}

}  // namespace

WrapDecision::WrapDecision(int pmd_width, int pmd_height, double focal, std::uint32_t range,
                           Arena& arena) noexcept
    : window_(pmd_width, pmd_height, range, arena),
      surfaces_(pmd_width, pmd_height, arena),
      regions_(pixel_count(pmd_width, pmd_height), arena),
      slant_divisor_(static_cast<std::uint32_t>(std::max(focal / 2, 1.0))),
      slants_(arena.take_passing<std::int32_t>(index(pmd_width))),
      open_(arena.take_filled(pixel_count(pmd_width, pmd_height + 2), std::uint8_t{0})),
      beside_(arena.take_passing<std::uint8_t>(index(pmd_width))) {}

void WrapDecision::link_all(const WrapMaps& maps) noexcept {
  const std::size_t row = index(maps.width);
  const std::span<const Reading> readings = maps.readings;
  for (int y = 0; y < maps.height; ++y) {
    const std::size_t first = maps.place(0, y);
    for (std::size_t x = 0; x < row; ++x) {
      const int wraps = std::max<int>(maps.vote[first + x], 0);
      slants_[x] = static_cast<std::int32_t>(maps.distance(first + x, wraps) / slant_divisor_);
    }
    const std::span<SurfaceLink> right = surfaces_.right_row(y);
    const std::span<SurfaceLink> below = surfaces_.below_row(y);
    link_row(readings.subspan(first, row - 1), readings.subspan(first + 1, row - 1), slants_,
             static_cast<int>(maps.range), right);
    right.back() = kBroken;
    if (y + 1 < maps.height) {
      link_row(readings.subspan(first, row), readings.subspan(first + row, row), slants_,
               static_cast<int>(maps.range), below);
    } else {
      std::ranges::fill(below, kBroken);
    }
  }
}

// Whether readings around that were voted for leave little doubt about its wrap count.
bool WrapDecision::prevails(const WrapMaps& maps, int x, int y, int wanted) const noexcept {
  int mine = 0;
  int rival = 0;
  const DistanceVotes::Around around = window_.around(x, y);
  const std::uint32_t range = maps.range;
  std::uint32_t distance = maps.readings[maps.place(x, y)].distance;
  for (int k = 0; k < maps.wrap_counts && distance <= kMaxQuarterMm; ++k, distance += range) {
    const int votes = around.of(static_cast<QuarterMm>(distance));
    mine = k == wanted ? votes : mine;
    rival = k == wanted ? rival : std::max(rival, votes);
  }
  return mine >= kLeastAround && 2 * mine >= 3 * rival;
}

// What most of its surface says, and the reading itself if it says anything.
std::int8_t WrapDecision::by_surface(const WrapMaps& maps, int x, int y) const noexcept {
  const std::size_t i = maps.place(x, y);
  const std::int8_t own = maps.vote[i];
  const SurfaceVotes::Counts counts = surfaces_.around(x, y);
  int winner = 0;
  int most = 0;
  int voters = 0;
  for (int k = 0; k < maps.wrap_counts; ++k) {
    const int count = counts[index(k)];
    winner = count > most ? k : winner;
    most = std::max(most, count);
    voters += count;
  }
  if (voters == 0) {
    return own;
  }
  const int all = counts.back();
  const bool agrees = own == kUnknownWraps || own == winner;
  if (!agrees || most < std::min(kLeastAround, all) || 2 * most < all ||
      8 * (voters - most) > most || !prevails(maps, x, y, winner)) {
    return own == kUnknownWraps ? kUnknownWraps : kDisputedWraps;
  }
  return has_bit(maps.possible, i, winner) ? static_cast<std::int8_t>(winner) : kRefutedWraps;
}

void WrapDecision::decide_by_surfaces(WrapMaps& maps) noexcept {
  window_.clear();
  for (int y = 0; y < maps.height; ++y) {
    for (int x = 0; x < maps.width; ++x) {
      const std::size_t i = maps.place(x, y);
      if (maps.vote[i] >= 0) {
        window_.add(x, y, static_cast<QuarterMm>(maps.distance(i, maps.vote[i])));
      }
    }
  }
  window_.sum();
  surfaces_.sum(maps.vote, maps.wrap_counts);
  // Local spans: bytes that are written cannot change them.
  const std::span<const std::int8_t> vote = maps.vote;
  const std::span<const bool> bright = maps.bright;
  const std::span<std::int8_t> wraps = maps.wraps;
  std::size_t i = 0;
  for (int y = 0; y < maps.height; ++y) {
    for (int x = 0; x < maps.width; ++x, ++i) {
      const bool open = vote[i] != kNoReading && !bright[i];
      wraps[i] = open ? by_surface(maps, x, y) : vote[i];
    }
  }
}

// Only what is open joins: with itself and with the decided readings at its border.
void WrapDecision::join_regions(const WrapMaps& maps) noexcept {
  regions_.clear();
  const std::size_t all = maps.pixels();
  const std::size_t row = index(maps.width);
  const auto join = [&](std::size_t a, std::size_t b, SurfaceLink link) {
    if (maps.wraps[a] == kUnknownWraps || maps.wraps[b] == kUnknownWraps) {
      regions_.unite(a, b, link);
    }
  };
  for (std::size_t i = 0; i < all; ++i) {
    if (const SurfaceLink right = surfaces_.right(i); goes_on(right)) {
      join(i, i + 1, right);
    }
    if (const SurfaceLink below = surfaces_.below(i); goes_on(below)) {
      join(i, i + row, below);
    }
  }
  // What is decided and stands alone speaks for nobody.
  for (std::size_t i = 0; i < all; ++i) {
    if (maps.bright[i] && !regions_.stands_alone(i)) {
      regions_.prove(i);
    }
  }
  for (std::size_t i = 0; i < all; ++i) {
    if (maps.wraps[i] >= 0 && !maps.bright[i] && !regions_.stands_alone(i)) {
      regions_.contradict(i, maps.wraps[i]);
    }
  }
}

// The wrap count of an open reading from its region, what is possible and its brightness.
std::int8_t WrapDecision::decide_last(const AmplitudeBound& bound, const WrapMaps& maps,
                                      std::size_t i) noexcept {
  const std::int8_t so_far = maps.wraps[i];
  if (so_far >= 0 || so_far == kNoReading || so_far == kRefutedWraps) {
    return so_far;
  }
  const int region = so_far == kUnknownWraps ? regions_.wraps(i) : WrapRegions::kUndecided;
  if (region != WrapRegions::kUndecided) {
    const bool fits = region >= 0 && region < maps.wrap_counts;
    return fits && has_bit(maps.possible, i, region) ? static_cast<std::int8_t>(region)
                                                     : kRefutedWraps;
  }
  if (maps.possible[i] == 1) {
    return 0;
  }
  const bool near = so_far == kUnknownWraps && !bound.known() &&
                    bound.outshines(maps.readings[i], maps.distance(i, 1));
  return near ? std::int8_t{0} : kRefutedWraps;
}

// Whether a reading may be mixed with one of unknown wrap count beside it: where it does not go on
// to the other side. What stereo sees may change in amplitude there, and be slanted.
bool WrapDecision::may_be_mixed(const WrapMaps& maps, int x, int y) const noexcept {
  const std::size_t row = index(maps.width);
  const std::size_t i = maps.place(x, y);
  const auto open = [&](std::size_t other) {
    return maps.wraps[other] < 0 && maps.wraps[other] != kNoReading;
  };
  const bool open_left = x > 0 && open(i - 1);
  const bool open_right = x + 1 < maps.width && open(i + 1);
  const bool open_above = y > 0 && open(i - row);
  const bool open_below = y + 1 < maps.height && open(i + row);
  if (!open_left && !open_right && !open_above && !open_below) {
    return false;
  }
  const SurfaceLink worst = maps.seen[i] ? kDimmed : SurfaceLink{1};
  const auto torn = [&](bool open_here, SurfaceLink here, bool open_there, SurfaceLink there) {
    return open_here && here != kBlurred && (there > worst || open_there);
  };
  const SurfaceLink left = x > 0 ? surfaces_.right(i - 1) : kBroken;
  const SurfaceLink above = y > 0 ? surfaces_.below(i - row) : kBroken;
  const SurfaceLink right = surfaces_.right(i);
  const SurfaceLink below = surfaces_.below(i);
  return torn(open_left, left, open_right, right) || torn(open_right, right, open_left, left) ||
         torn(open_above, above, open_below, below) || torn(open_below, below, open_above, above);
}

// First which readings may be, while the wrap counts around are as they were decided.
void WrapDecision::drop_mixed(WrapMaps& maps) noexcept {
  const std::size_t all = maps.pixels();
  const std::size_t row = index(maps.width);
  // Local spans: bytes that are written cannot change them.
  const std::span<const std::int8_t> wraps = maps.wraps;
  const std::span<std::uint8_t> open = open_;
  const std::span<std::uint8_t> beside = beside_;
  for (std::size_t i = 0; i < all; ++i) {
    open[row + i] = wraps[i] < 0 && wraps[i] != kNoReading ? 1 : 0;
  }
  std::ranges::copy(maps.wraps, maps.vote.begin());
  for (int y = 0; y < maps.height; ++y) {
    const std::size_t first = maps.place(0, y);
    const std::span<const std::uint8_t> above = open.subspan(first, row);
    const std::span<const std::uint8_t> below = open.subspan(first + 2 * row, row);
    const std::span<const std::uint8_t> before = open.subspan(first + row - 1, row);
    const std::span<const std::uint8_t> behind = open.subspan(first + row + 1, row);
    for (std::size_t x = 0; x < row; ++x) {
      beside[x] = static_cast<std::uint8_t>(above[x] | below[x] | before[x] | behind[x]);
    }
    for (int x = 0; x < maps.width; ++x) {
      const std::size_t i = first + index(x);
      if (beside[index(x)] != 0 && wraps[i] >= 0 && may_be_mixed(maps, x, y)) {
        maps.vote[i] = kRefutedWraps;
      }
    }
  }
  std::ranges::copy(maps.vote, maps.wraps.begin());
}

void WrapDecision::decide(AmplitudeBound& bound, WrapMaps& maps) noexcept {
  link_all(maps);
  decide_by_surfaces(maps);
  join_regions(maps);
  const std::size_t all = maps.pixels();
  if (!bound.known()) {
    for (std::size_t i = 0; i < all; ++i) {
      if (maps.wraps[i] >= 0) {
        bound.learn(maps.readings[i], maps.distance(i, maps.wraps[i]));
      }
    }
    bound.end_learning();
  }
  // Local spans, as above.
  const std::span<const std::int8_t> vote = maps.vote;
  const std::span<const std::uint16_t> mixed = maps.mixed;
  const std::span<std::int8_t> decided = maps.wraps;
  const std::span<bool> seen = maps.seen;
  for (std::size_t i = 0; i < all; ++i) {
    const std::int8_t so_far = decided[i];
    const std::int8_t wraps = so_far >= 0 ? so_far : decide_last(bound, maps, i);
    seen[i] = wraps > 0 && vote[i] == wraps;
    decided[i] = wraps >= 0 && has_bit(mixed, i, wraps) ? kRefutedWraps : wraps;
  }
  drop_mixed(maps);
}

}  // namespace stof::dsp
