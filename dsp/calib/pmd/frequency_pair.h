#pragma once

#include "dsp/base/units.h"
#include "dsp/pmd/range/combine_frequencies.h"

namespace stof::dsp {

// Whether two frequencies tell wrap counts apart that each of them alone does not: first > second,
// and first / second = m / n in lowest terms with m <= kMostTurns. Noise sets the bound: turns are
// known as long as the noise of both phases stays below about 0.95 / sqrt(m^2 + n^2) rad (0.0435
// for 20 + 18.75 MHz, 0.011 for m = 64), and no pixel is steady enough for more.
bool usable_pair(Hertz first, Hertz second) noexcept;

// Takes a usable pair. Phases may disagree by a quarter of a turn of the beat. A wrong turn becomes
// possible when noise reaches 3/4 of that; this must be at least 5 sigma away.
FrequencyPair make_frequency_pair(Hertz first, Hertz second) noexcept;

// After what distance both phases repeat, 0.1 mm.
std::uint32_t common_range(const FrequencyPair& pair) noexcept;

}  // namespace stof::dsp
