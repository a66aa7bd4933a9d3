#include <algorithm>
#include <memory>
#include <type_traits>

#include "dsp/base/check.h"
#include "dsp/stereo/check/distinct.h"
#include "dsp/stereo/check/speckle.h"
#include "dsp/stereo/check/texture.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "dsp/stereo/map_search.h"
#include "dsp/stereo/matcher.h"
#include "dsp/stereo/search/energy.h"

// What a Matcher takes from its Arena.
namespace stof::dsp {
namespace {

std::size_t size(int value) noexcept { return static_cast<std::size_t>(value); }

bool fills(const MatchParams& params) noexcept {
  return params.fill || params.method == Method::kOrdered;
}

bool keeps_weak(const MatchParams& params) noexcept {
  return params.confidence && (params.distinct || params.min_texture);
}

// The most that a step takes for itself in each thread.
std::size_t row_scratch_bytes(const MatchParams& params, int width) noexcept {
  const std::size_t right = size(width) + size(lanes_of(params)) - 1;
  std::size_t bytes =
      Arena::bytes_for<std::uint32_t>(right) + Arena::bytes_for<std::int16_t>(right);
  if (params.distinct) {
    bytes = std::max(bytes, drop_indistinct_bytes(width));
  }
  if (params.min_texture) {
    bytes = std::max(bytes, drop_flat_bytes(width));
  }
  return Arena::bytes_for<std::byte>(bytes);
}

// The most that one step takes for itself.
std::size_t scratch_bytes(const MatchParams& params, int width, int height, int threads) noexcept {
  std::size_t bytes = size(threads) * row_scratch_bytes(params, width);
  const auto needs = [&](std::size_t more) noexcept { bytes = std::max(bytes, more); };
  if (params.histogram_permille) {
    needs(Arena::bytes_for<std::uint32_t>(size(params.disparities) + 1));
  }
  if (params.speckle_pixels) {
    // The map and what was there before go through it at the same time.
    const std::size_t maps = keeps_weak(params) && threads > 1 ? 2 : 1;
    needs(maps * Arena::bytes_for<std::byte>(drop_speckles_bytes(width, height)));
  }
  if (searches_map(params)) {
    needs(Arena::bytes_for<std::int16_t>(size(width) * size(height)) +
          search_map_bytes(params, width, height));
  }
  return bytes;
}

// Searches of whole maps ask one search for costs, if any.
int searches_for(const MatchParams& params, int threads) noexcept {
  return searches_map(params) ? 1 : threads;
}

template <typename Sum>
std::size_t searches_bytes(const MatchParams& params, int width, int count) noexcept {
  return Arena::bytes_for<std::byte>(size(count) * sizeof(RowSearch<Sum>)) +
         size(count) * RowSearch<Sum>::bytes_needed(params, width);
}

template <typename Sum>
std::span<RowSearch<Sum>> make_searches(const MatchParams& params, int width, int count,
                                        Arena& arena) noexcept {
  using Search = RowSearch<Sum>;
  static_assert(std::is_trivially_destructible_v<Search> && alignof(Search) <= Arena::kAlign);
  std::byte* const memory = arena.take<std::byte>(size(count) * sizeof(Search)).data();
  auto* const searches = reinterpret_cast<Search*>(memory);  // NOLINT: made in the next lines
  for (int k = 0; k < count; ++k) {
    std::construct_at(searches + k, params, width, arena);
  }
  return {searches, size(count)};
}

}  // namespace

std::size_t Matcher::bytes_needed(const MatchParams& params, int width, int height,
                                  int threads) noexcept {
  const std::size_t pixels = size(width) * size(height);
  const int searches = searches_for(params, threads);
  std::size_t bytes =
      PreparedPair::bytes_needed(params, width, height) +
      (needs_wide_sums(params) ? searches_bytes<std::uint32_t>(params, width, searches)
                               : searches_bytes<std::uint16_t>(params, width, searches));
  bytes += params.distinct ? Arena::bytes_for<std::int16_t>(pixels) : 0;
  bytes += params.median || keeps_weak(params) ? Arena::bytes_for<Disparity>(pixels) : 0;
  bytes += fills(params) ? Arena::bytes_for<std::uint8_t>(pixels) : 0;
  bytes += params.confidence ? Arena::bytes_for<std::uint8_t>(pixels) : 0;
  bytes += keeps_weak(params) && !params.distinct ? Arena::bytes_for<Disparity>(pixels) : 0;
  return bytes + Arena::bytes_for<std::byte>(scratch_bytes(params, width, height, threads));
}

Matcher::Matcher(const MatchParams& params, int width, int height, Arena& arena,
                 const Crew& crew) noexcept
    : params_(params),
      crew_(crew),
      pair_(params, width, height, arena),
      thread_bytes_(row_scratch_bytes(params, width)),
      map_bytes_(params.speckle_pixels && keeps_weak(params) && crew.threads() > 1
                     ? Arena::bytes_for<std::byte>(drop_speckles_bytes(width, height))
                     : 0) {
  STOF_CHECK(check(params, width, height) == Status::kOk);
  const int searches = searches_for(params, crew.threads());
  if (needs_wide_sums(params)) {
    wide_searches_ = make_searches<std::uint32_t>(params, width, searches, arena);
  } else {
    searches_ = make_searches<std::uint16_t>(params, width, searches, arena);
  }
  if (params.distinct) {
    margins_ = arena.take_image<std::int16_t>(width, height);
  }
  if (params.median || keeps_weak(params)) {
    spare_ = arena.take_image<Disparity>(width, height);
  }
  if (fills(params)) {
    filled_ = arena.take_image<std::uint8_t>(width, height);
  }
  if (params.confidence) {
    ratio_ = arena.take_image<std::uint8_t>(width, height);
  }
  if (keeps_weak(params)) {
    // Margins are of no use once the indistinct ones are dropped.
    weak_ = params.distinct
                ? ImageView<Disparity>(
                      reinterpret_cast<Disparity*>(margins_.data()),  // NOLINT: both are an i16
                      width, height)
                : arena.take_image<Disparity>(width, height);
  }
  scratch_ = arena.take<std::byte>(scratch_bytes(params, width, height, crew.threads()));
}

}  // namespace stof::dsp
