#include "dsp/base/lanes_neon.h"
#include "dsp/stereo/search/path_costs_body.h"

namespace stof::dsp::neon {
namespace {

template <typename Cost>
struct Isa : Lanes<Cost> {};

}  // namespace

template <typename Cost>
void paths_along(std::span<const Cost> costs, int lanes, Cost small, std::span<const Cost> large,
                 bool from_left, std::span<Cost> paths) noexcept {
  path_costs_body::along<Isa<Cost>>(costs, lanes, small, large, from_left, paths);
}

template <typename Cost>
void paths_both_ways(std::span<const Cost> costs, int lanes, Cost small,
                     std::span<const Cost> large_from_left, std::span<const Cost> large_from_right,
                     std::span<Cost> from_left, std::span<Cost> from_right) noexcept {
  path_costs_body::both_ways<Isa<Cost>>(costs, lanes, small, large_from_left, large_from_right,
                                        from_left, from_right);
}

template <typename Cost>
void paths_across(std::span<const Cost> costs, std::span<const Cost> before, int shift, int lanes,
                  Cost small, std::span<const Cost> large, std::span<Cost> paths) noexcept {
  path_costs_body::across<Isa<Cost>>(costs, before, shift, lanes, small, large, paths);
}

template <typename Cost>
void paths_of_axes(const AxesRow<Cost>& row, std::span<Cost> front, std::span<const Cost> others,
                   std::span<Cost> sums) noexcept {
  path_costs_body::axes<Isa<Cost>>(row, front, others, sums);
}

template PathsAlong<std::uint8_t> paths_along<std::uint8_t>;
template PathsAlong<std::uint16_t> paths_along<std::uint16_t>;
template PathsAlong<std::uint32_t> paths_along<std::uint32_t>;
template PathsBothWays<std::uint8_t> paths_both_ways<std::uint8_t>;
template PathsBothWays<std::uint16_t> paths_both_ways<std::uint16_t>;
template PathsBothWays<std::uint32_t> paths_both_ways<std::uint32_t>;
template PathsAcross<std::uint8_t> paths_across<std::uint8_t>;
template PathsAcross<std::uint16_t> paths_across<std::uint16_t>;
template PathsAcross<std::uint32_t> paths_across<std::uint32_t>;
template PathsOfAxes<std::uint8_t> paths_of_axes<std::uint8_t>;
template PathsOfAxes<std::uint16_t> paths_of_axes<std::uint16_t>;

}  // namespace stof::dsp::neon
