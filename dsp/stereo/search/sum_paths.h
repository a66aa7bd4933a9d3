#pragma once

#include <cstdint>
#include <span>

#include "dsp/base/target.h"

namespace stof::dsp {

// sums[i] = the sum over 2 to 8 rows of paths (search/path.h) of paths[k][i], saturated where Sum
// is u8. Each row has sums.size() elements, a multiple of 16; u16 paths are below 8192. No overlap.
template <typename Cost, typename Sum>
using SumPaths = void(std::span<const Cost* const> paths, std::span<Sum> sums) noexcept;

namespace ref {
SumPaths<std::uint8_t, std::uint8_t> sum_paths;
SumPaths<std::uint8_t, std::uint16_t> sum_paths;
SumPaths<std::uint16_t, std::uint16_t> sum_paths;
}  // namespace ref
namespace neon {
SumPaths<std::uint8_t, std::uint8_t> sum_paths;
SumPaths<std::uint8_t, std::uint16_t> sum_paths;
SumPaths<std::uint16_t, std::uint16_t> sum_paths;
}  // namespace neon
namespace avx2 {
SumPaths<std::uint8_t, std::uint8_t> sum_paths;
}  // namespace avx2
namespace best {
inline constexpr Kernel<SumPaths<std::uint8_t, std::uint8_t>, SumPaths<std::uint8_t, std::uint16_t>,
                        SumPaths<std::uint16_t, std::uint16_t>>
    sum_paths{STOF_VARIANTS(sum_paths), STOF_PORTABLE(sum_paths), STOF_PORTABLE(sum_paths)};
}  // namespace best

}  // namespace stof::dsp
