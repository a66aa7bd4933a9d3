#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <queue>
#include <random>
#include <span>
#include <vector>

namespace stof::netem {

using Time = std::chrono::steady_clock::time_point;
using Duration = std::chrono::steady_clock::duration;

// A bad network. Shares are of datagrams, 0 to 1.
struct ImpairmentOptions {
  double loss = 0;
  double burst = 1;  // mean length of a loss, datagrams, at least 1; `loss` stays the share
  double duplicate = 0;
  double corrupt = 0;  // one to three bits of the datagram are turned
  int reorder = 0;     // how many later datagrams may overtake one
  Duration delay{};    // of each
  Duration jitter{};   // more delay, between 0 and this: reorders as well
  std::uint64_t seed = 1;
};

// Datagrams in, what arrives of them out. The same seed, datagrams and times do the same. No clock
// and no socket: `now` is the caller's, and must not go back.
class Impairment {
 public:
  struct Counts {
    std::uint64_t in = 0;
    std::uint64_t out = 0;
    std::uint64_t lost = 0;  // on purpose
    std::uint64_t duplicated = 0;
    std::uint64_t corrupted = 0;
    std::uint64_t overflowed = 0;  // lost because kMostWaiting were on their way
  };

  explicit Impairment(const ImpairmentOptions& options);

  void push(std::span<const std::byte> datagram, Time now);
  // The next that has arrived, valid until the next call of push() or pop().
  std::optional<std::span<const std::byte>> pop(Time now);
  // When pop() will have something, if nothing more is pushed.
  std::optional<Time> next() const;

  const Counts& counts() const noexcept { return counts_; }

 private:
  static constexpr std::size_t kMostWaiting = 65'536;
  // Those held back for later ones go on after this where no later ones come.
  static constexpr std::chrono::milliseconds kLongestHold{20};

  struct Item {
    std::vector<std::byte> bytes;
    std::uint64_t overtaken_by = 0;  // arrival of this datagram, counted from 1, ends the hold
    std::uint64_t order = 0;
    Time due;  // of a held one: when the hold ends at the latest
  };
  struct Later {
    bool operator()(const Item& a, const Item& b) const noexcept {
      return a.due != b.due ? a.due > b.due : a.order > b.order;
    }
  };

  bool happens(double share);
  bool loses();
  void hold(std::vector<std::byte> bytes, Time now);
  void release(Time now);
  void corrupt(std::vector<std::byte>& bytes);

  ImpairmentOptions options_;
  std::mt19937_64 random_;
  Counts counts_;
  bool losing_ = false;
  std::uint64_t order_ = 0;
  std::vector<Item> held_;  // for reordering
  std::priority_queue<Item, std::vector<Item>, Later> travelling_;
  std::vector<std::byte> out_;
};

}  // namespace stof::netem
