#pragma once

#include <cstdint>

namespace stof::host {

// The phase kernel against atan2 in double precision, on random samples.
struct PhaseScore {
  long pixels = 0;
  double largest_lsb = 0;     // one LSB is 1/65536 turn
  double mean_lsb = 0;        // of the magnitudes
  bool kernels_equal = true;  // every output of `ref` and `neon`, bit for bit
};

// Samples of `bits` bits, 10 to 15. The same seed gives the same samples.
PhaseScore score_phase(long pixels, int bits = 12, std::uint64_t seed = 1);

}  // namespace stof::host
