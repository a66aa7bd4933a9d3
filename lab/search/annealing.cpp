#include "lab/search/annealing.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "dsp/base/check.h"
#include "dsp/base/random.h"
#include "dsp/stereo/search/winner.h"
#include "lab/search/metropolis.h"

namespace stof::lab {
namespace {

// At `sweep`: halved each sweeps / halvings, a straight line between. Fraction bits kHeatBits, so
// that its product with temperatures() fits 64 bits.
constexpr int kHeatBits = 8;
std::uint64_t temperature_at(const AnnealingParams& params, int sweep) noexcept {
  const std::uint64_t halvings =
      ((static_cast<std::uint64_t>(params.halvings) * static_cast<std::uint64_t>(sweep))
       << kLogBits) /
      static_cast<std::uint64_t>(params.sweeps);
  const std::uint64_t fraction = halvings & ((std::uint64_t{1} << kLogBits) - 1);
  const std::uint64_t start = std::uint64_t{params.temperature} << kHeatBits;
  const std::uint64_t whole = start >> (halvings >> kLogBits);
  return whole - ((whole * fraction) >> (kLogBits + 1));
}

template <typename Sum>
class Annealer {
 public:
  Annealer(std::span<const Sum> costs, int lanes, std::uint32_t lambda,
           ImageView<std::int16_t> map) noexcept
      : costs_(costs), lanes_(lanes), lambda_(lambda), map_(map) {}

  // False where no pixel has a winner.
  bool begin() noexcept {
    bool any = false;
    for (int y = 0; y < map_.height(); ++y) {
      any = any || std::ranges::any_of(map_.row(y), [](int w) { return w != kNoWinner; });
    }
    for (int y = 0; any && y < map_.height(); ++y) {
      for (int x = 0; x < map_.width(); ++x) {
        complete(x, y);
      }
    }
    return any;
  }

  // Each pixel once. temperature: as temperature_at(); 0 accepts no rise. Returns the change.
  std::int64_t sweep(std::uint64_t temperature, dsp::SplitMix64& dice) noexcept {
    std::int64_t change = 0;
    for (int y = 0; y < map_.height(); ++y) {
      for (int x = 0; x < map_.width(); ++x) {
        const int now = map_.at(x, y);
        if (now == kNoWinner) {
          continue;
        }
        const std::uint64_t random = dice.next();
        const Neighbours near = neighbours(x, y);
        const int proposed = propose(near, now, static_cast<std::uint32_t>(random >> 32U));
        if (proposed < 0 || proposed >= lanes_ || proposed == now || !offered(x, y, proposed)) {
          continue;
        }
        const std::int64_t rise = rise_to(x, y, near, now, proposed);
        if (rise <= 0 || allowed(rise, temperature, static_cast<std::uint32_t>(random))) {
          map_.at(x, y) = static_cast<std::int16_t>(proposed);
          change += rise;
        }
      }
    }
    return change;
  }

  // The best candidate for each pixel, until none is better than the present one.
  std::int64_t descend() noexcept {
    std::int64_t change = 0;
    for (bool moved = true; moved;) {
      moved = false;
      for (int y = 0; y < map_.height(); ++y) {
        for (int x = 0; x < map_.width(); ++x) {
          const std::int64_t rise = improve(x, y);
          change += rise;
          moved = moved || rise < 0;
        }
      }
    }
    return change;
  }

 private:
  const Sum* pixel(int x, int y) const noexcept {
    const std::size_t at = static_cast<std::size_t>(y) * static_cast<std::size_t>(map_.width()) +
                           static_cast<std::size_t>(x);
    return costs_.data() + at * static_cast<std::size_t>(lanes_);
  }
  bool offered(int x, int y, int candidate) const noexcept {
    return pixel(x, y)[candidate] != kNoCost<Sum>;
  }

  void complete(int x, int y) noexcept {
    const std::span<const Sum> costs(pixel(x, y), static_cast<std::size_t>(lanes_));
    std::int16_t& winner = map_.at(x, y);
    const auto cheapest = std::ranges::min_element(costs);
    if (winner == kNoWinner || !offered(x, y, winner)) {
      winner = *cheapest == kNoCost<Sum> ? kNoWinner
                                         : static_cast<std::int16_t>(cheapest - costs.begin());
    }
  }

  // Those of the four that have a candidate.
  struct Neighbours {
    std::array<int, 4> candidates{};
    std::uint32_t count = 0;
    void add(int candidate) noexcept {
      candidates[count] = candidate;
      count += candidate == kNoWinner ? 0 : 1;
    }
  };
  Neighbours neighbours(int x, int y) const noexcept {
    const std::int16_t* const here = map_.data() + y * map_.stride() + x;
    Neighbours near;
    near.add(x > 0 ? here[-1] : kNoWinner);
    near.add(x + 1 < map_.width() ? here[1] : kNoWinner);
    near.add(y > 0 ? here[-map_.stride()] : kNoWinner);
    near.add(y + 1 < map_.height() ? here[map_.stride()] : kNoWinner);
    return near;
  }

  // Half of the proposals copy a neighbour, most others go one step, some go anywhere.
  int propose(const Neighbours& near, int now, std::uint32_t random) const noexcept {
    const std::uint32_t kind = random & 15U;
    if (kind < 8) {
      return near.count == 0 ? now : near.candidates[(random >> 4U) % near.count];
    }
    if (kind < 15) {
      return (random & 16U) != 0 ? now + 1 : now - 1;
    }
    return static_cast<int>((random >> 4U) % static_cast<std::uint32_t>(lanes_));
  }

  std::int64_t rise_to(int x, int y, const Neighbours& near, int now, int proposed) const noexcept {
    std::int64_t steps = 0;
    for (std::uint32_t k = 0; k < near.count; ++k) {
      steps += std::abs(proposed - near.candidates[k]) - std::abs(now - near.candidates[k]);
    }
    const Sum* const costs = pixel(x, y);
    return std::int64_t{costs[proposed]} - std::int64_t{costs[now]} + steps * lambda_;
  }

  static bool allowed(std::int64_t rise, std::uint64_t temperature, std::uint32_t random) noexcept {
    return static_cast<std::uint64_t>(rise) <= (temperature * temperatures(random)) >>
           (kHeatBits + kLogBits);
  }

  std::int64_t improve(int x, int y) noexcept {
    const int now = map_.at(x, y);
    if (now == kNoWinner) {
      return 0;
    }
    const Neighbours near = neighbours(x, y);
    std::int64_t best = 0;
    for (int candidate = 0; candidate < lanes_; ++candidate) {
      const std::int64_t rise = offered(x, y, candidate) ? rise_to(x, y, near, now, candidate) : 0;
      if (rise < best) {
        best = rise;
        map_.at(x, y) = static_cast<std::int16_t>(candidate);
      }
    }
    return best;
  }

  std::span<const Sum> costs_;
  int lanes_;
  std::uint32_t lambda_;
  ImageView<std::int16_t> map_;
};

void copy(ImageView<const std::int16_t> from, ImageView<std::int16_t> to) noexcept {
  for (int y = 0; y < from.height(); ++y) {
    std::ranges::copy(from.row(y), to.row(y).begin());
  }
}

}  // namespace

AnnealingParams default_annealing(std::uint32_t lambda) noexcept {
  return {.lambda = lambda, .temperature = 4 * lambda};
}

template <typename Sum>
std::uint64_t map_energy(std::span<const Sum> costs, int lanes, std::uint32_t lambda,
                         ImageView<const std::int16_t> map) noexcept {
  std::uint64_t data = 0;
  std::uint64_t steps = 0;
  const Sum* pixel = costs.data();
  for (int y = 0; y < map.height(); ++y) {
    for (int x = 0; x < map.width(); ++x, pixel += lanes) {
      const int here = map.at(x, y);
      if (here == kNoWinner) {
        continue;
      }
      data += pixel[here];
      const int left = x > 0 ? map.at(x - 1, y) : kNoWinner;
      const int above = y > 0 ? map.at(x, y - 1) : kNoWinner;
      steps += left == kNoWinner ? 0U : static_cast<std::uint64_t>(std::abs(here - left));
      steps += above == kNoWinner ? 0U : static_cast<std::uint64_t>(std::abs(here - above));
    }
  }
  return data + lambda * steps;
}

template <typename Sum>
AnnealingEnergy anneal(std::span<const Sum> costs, int lanes, const AnnealingParams& params,
                       ImageView<std::int16_t> best, ImageView<std::int16_t> map) noexcept {
  STOF_CHECK(same_size(best, map) && params.sweeps >= 1 && params.halvings >= 0 &&
             params.halvings < 32);
  STOF_CHECK(costs.size() == static_cast<std::size_t>(map.width()) *
                                 static_cast<std::size_t>(map.height()) *
                                 static_cast<std::size_t>(lanes));
  Annealer<Sum> annealer(costs, lanes, params.lambda, map);
  if (!annealer.begin()) {
    return {};
  }
  copy(map, best);
  AnnealingEnergy energy;
  energy.start = map_energy(costs, lanes, params.lambda, map);
  energy.end = energy.start;
  std::int64_t now = static_cast<std::int64_t>(energy.start);
  dsp::SplitMix64 dice(params.seed);
  const auto keep_if_best = [&]() noexcept {
    if (static_cast<std::uint64_t>(now) < energy.end) {
      energy.end = static_cast<std::uint64_t>(now);
      copy(map, best);
    }
  };
  for (int sweep = 0; sweep < params.sweeps; ++sweep) {
    const bool rises = params.acceptance == Acceptance::kMetropolis;
    now += annealer.sweep(rises ? temperature_at(params, sweep) : 0, dice);
    keep_if_best();
  }
  copy(best, map);
  energy.end =
      static_cast<std::uint64_t>(static_cast<std::int64_t>(energy.end) + annealer.descend());
  return energy;
}

template std::uint64_t map_energy(std::span<const std::uint16_t>, int, std::uint32_t,
                                  ImageView<const std::int16_t>) noexcept;
template std::uint64_t map_energy(std::span<const std::uint32_t>, int, std::uint32_t,
                                  ImageView<const std::int16_t>) noexcept;
template AnnealingEnergy anneal(std::span<const std::uint16_t>, int, const AnnealingParams&,
                                ImageView<std::int16_t>, ImageView<std::int16_t>) noexcept;
template AnnealingEnergy anneal(std::span<const std::uint32_t>, int, const AnnealingParams&,
                                ImageView<std::int16_t>, ImageView<std::int16_t>) noexcept;

}  // namespace stof::lab
