#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "tests/fuzz/pairing_steps.h"

// libFuzzer changes bytes; what leads deep into a pairing is several steps in their order. So half
// of the changes here are of whole steps: the way of a client is put in, at once or between the
// steps of others, steps change places, go, or become another client's.

// NOLINTBEGIN(readability-identifier-naming): libFuzzer's names.
extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned int seed);
// NOLINTEND(readability-identifier-naming)

namespace stof::fuzz {
namespace {

using enum PairingStep;
using Steps = std::vector<std::vector<std::uint8_t>>;

// What leads to a key, or nearly. The cable's own steps come over it; the client's over either way.
constexpr std::array<std::array<PairingStep, 6>, 8> kWays{{
    {kPress, kBeginDigits, kReveal, kConfirm, kHold, kConfirm},
    {kPress, kBeginDigits, kReveal, kHold, kConfirm, kConfirm},
    {kOpen, kBeginDigits, kReveal, kConfirm, kAccept, kConfirm},
    {kOpen, kBeginDigits, kReveal, kAccept, kOpen, kConfirm},
    {kBeginCode, kReveal, kConfirm, kConfirm, kKeys, kConfirm},
    {kBeginCable, kReveal, kConfirm, kConfirm, kRenew, kReveal},
    {kRenew, kReveal, kConfirm, kRenew, kReveal, kConfirm},
    {kPress, kBeginDigits, kReveal, kWait, kWait, kConfirm},
}};

class Random {
 public:
  explicit Random(unsigned seed) noexcept : state_(seed * 2'654'435'769U | 1U) {}
  std::size_t below(std::size_t bound) noexcept {
    state_ ^= state_ << 13U;
    state_ ^= state_ >> 17U;
    state_ ^= state_ << 5U;
    return bound == 0 ? 0 : state_ % bound;
  }

 private:
  std::uint32_t state_;
};

Steps steps_in(std::span<const std::uint8_t> bytes) {
  Steps steps;
  while (!bytes.empty()) {
    const std::size_t length = std::min(bytes.size(), 1 + bytes_after(bytes[0]));
    steps.emplace_back(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    bytes = bytes.subspan(length);
  }
  return steps;
}

void put_way_in(Steps& steps, Random& random) {
  const auto client = static_cast<unsigned>(random.below(4));
  const bool spread = random.below(2) == 0;
  std::size_t at = random.below(steps.size() + 1);
  for (const PairingStep step : kWays[random.below(kWays.size())]) {
    const bool cable = step == kOpen || step == kAccept || step == kBeginCable;
    const unsigned who = step == kAccept || step == kOpen ? 0 : client;
    steps.insert(steps.begin() + static_cast<std::ptrdiff_t>(at), {byte_of(step, who, cable)});
    at += 1 + (spread ? random.below(3) : 0);
    at = std::min(at, steps.size());
  }
}

void change(Steps& steps, Random& random) {
  if (steps.empty() || random.below(3) == 0) {
    put_way_in(steps, random);
    return;
  }
  const std::size_t at = random.below(steps.size());
  switch (random.below(5)) {
    case 0:
      std::swap(steps[at], steps[random.below(steps.size())]);
      return;
    case 1:
      steps.erase(steps.begin() + static_cast<std::ptrdiff_t>(at));
      return;
    case 2: {
      const std::vector<std::uint8_t> again = steps[at];
      steps.insert(steps.begin() + static_cast<std::ptrdiff_t>(at), again);
      return;
    }
    case 3:
      steps[at][0] ^= static_cast<std::uint8_t>((1 + random.below(3)) << 4U);
      return;
    default: {
      const auto what = static_cast<PairingStep>(random.below(16));
      std::vector<std::uint8_t> one{
          byte_of(what, static_cast<unsigned>(random.below(4)), random.below(2) == 0)};
      const std::size_t after = what == kAnything ? 0 : bytes_after(one[0]);
      for (std::size_t i = 0; i < after; ++i) {
        one.push_back(static_cast<std::uint8_t>(random.below(256)));
      }
      steps[at] = one;
      return;
    }
  }
}

}  // namespace
}  // namespace stof::fuzz

std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                    unsigned int seed) {
  using namespace stof::fuzz;
  Random random(seed);
  if (size == 0 || random.below(2) == 0) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  Steps steps = steps_in(std::span(data, size).subspan(1));
  for (std::size_t changes = 1 + random.below(3); changes > 0; --changes) {
    change(steps, random);
  }
  std::size_t bytes = 1;
  for (const std::vector<std::uint8_t>& step : steps) {
    if (bytes + step.size() > max_size) {
      break;
    }
    std::ranges::copy(step, data + bytes);
    bytes += step.size();
  }
  return bytes;
}
