#include "host/netem/impairment.h"

#include <algorithm>
#include <utility>

namespace stof::netem {
namespace {

constexpr double kAlways = 1;
constexpr int kMostBits = 3;
constexpr std::size_t kByteBits = 8;

// Uniform in [0, count). The distributions of the standard library differ between libraries.
std::uint64_t below(std::mt19937_64& random, std::uint64_t count) { return random() % count; }

}  // namespace

Impairment::Impairment(const ImpairmentOptions& options)
    : options_(options), random_(options.seed) {}

bool Impairment::happens(double share) {
  constexpr double kScale = 1.0 / 9007199254740992.0;  // 2^-53
  return static_cast<double>(random_() >> 11U) * kScale < share;
}

// Two states, as Gilbert's channel: a loss goes on with the chance that gives it its mean length.
bool Impairment::loses() {
  if (options_.loss <= 0 || options_.loss >= kAlways) {
    return options_.loss > 0;
  }
  const double length = std::max(options_.burst, 1 / (1 - options_.loss));
  const double end = 1 / length;
  const double begin = end * options_.loss / (1 - options_.loss);
  losing_ = happens(losing_ ? 1 - end : begin);
  return losing_;
}

void Impairment::push(std::span<const std::byte> datagram, Time now) {
  ++counts_.in;
  if (loses()) {
    ++counts_.lost;
  } else {
    const bool twice = happens(options_.duplicate);
    counts_.duplicated += twice ? 1 : 0;
    for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
      hold({datagram.begin(), datagram.end()}, now);
    }
  }
  release(now);
}

void Impairment::hold(std::vector<std::byte> bytes, Time now) {
  if (held_.size() + travelling_.size() >= kMostWaiting) {
    ++counts_.overflowed;
    return;
  }
  if (happens(options_.corrupt)) {
    corrupt(bytes);
  }
  const auto places = static_cast<std::uint64_t>(std::max(options_.reorder, 0)) + 1;
  held_.push_back({.bytes = std::move(bytes),
                   .overtaken_by = counts_.in + below(random_, places),
                   .order = ++order_,
                   .due = now + (places > 1 ? Duration(kLongestHold) : Duration(0))});
}

void Impairment::corrupt(std::vector<std::byte>& bytes) {
  if (bytes.empty()) {
    return;
  }
  ++counts_.corrupted;
  const std::uint64_t bits = 1 + below(random_, kMostBits);
  for (std::uint64_t i = 0; i < bits; ++i) {
    const std::uint64_t bit = below(random_, bytes.size() * kByteBits);
    bytes[bit / kByteBits] ^= std::byte{1} << (bit % kByteBits);
  }
}

// Those overtaken by enough, or held long enough, begin to travel.
void Impairment::release(Time now) {
  const auto stays = [this, now](const Item& item) {
    return item.overtaken_by > counts_.in && item.due > now;
  };
  const auto leaving = std::ranges::partition(held_, stays);
  std::ranges::sort(leaving, {},
                    [](const Item& item) { return std::pair(item.overtaken_by, item.order); });
  for (Item& item : leaving) {
    const std::int64_t jitter = options_.jitter.count();
    const std::int64_t more =
        jitter > 0
            ? static_cast<std::int64_t>(below(random_, static_cast<std::uint64_t>(jitter) + 1))
            : 0;
    item.due = now + options_.delay + Duration(more);
    item.order = ++order_;
    travelling_.push(std::move(item));
  }
  held_.erase(leaving.begin(), leaving.end());
}

std::optional<std::span<const std::byte>> Impairment::pop(Time now) {
  release(now);
  if (travelling_.empty() || travelling_.top().due > now) {
    return std::nullopt;
  }
  out_ = travelling_.top().bytes;
  travelling_.pop();
  ++counts_.out;
  return out_;
}

std::optional<Time> Impairment::next() const {
  std::optional<Time> first;
  for (const Item& item : held_) {
    first = first ? std::min(*first, item.due) : item.due;
  }
  if (!travelling_.empty()) {
    first = first ? std::min(*first, travelling_.top().due) : travelling_.top().due;
  }
  return first;
}

}  // namespace stof::netem
