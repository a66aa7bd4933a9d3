#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string_view>

namespace stof::fuzz {

// How many runs came so far as each of the places that a target names. Printed when the program
// ends, where STOF_FUZZ_REACHED is set.
template <std::size_t kPlaces>
class Reached {
 public:
  explicit Reached(const std::array<const char*, kPlaces>& names) noexcept : names_(names) {}
  ~Reached() {
    if (std::getenv("STOF_FUZZ_REACHED") == nullptr) {  // NOLINT(concurrency-mt-unsafe)
      return;
    }
    end_run();
    std::fprintf(stderr, "reached by, of %llu runs:\n", static_cast<unsigned long long>(runs_));
    for (std::size_t i = 0; i < kPlaces; ++i) {
      std::fprintf(stderr, "  %12llu %s\n", static_cast<unsigned long long>(counts_[i]), names_[i]);
    }
  }
  Reached(const Reached&) = delete;
  Reached& operator=(const Reached&) = delete;

  void begin_run() noexcept {
    end_run();
    ++runs_;
  }
  void note(std::size_t place) noexcept { here_[place] = true; }

 private:
  void end_run() noexcept {
    for (std::size_t i = 0; i < kPlaces; ++i) {
      counts_[i] += here_[i] ? 1U : 0U;
      here_[i] = false;
    }
  }

  std::array<const char*, kPlaces> names_;
  std::array<bool, kPlaces> here_{};
  std::array<std::uint64_t, kPlaces> counts_{};
  std::uint64_t runs_ = 0;
};

}  // namespace stof::fuzz
