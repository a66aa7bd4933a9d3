#include "lab/matcher.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "lab/fill.h"

namespace stof::lab {
namespace {

bool made_up(const MatchParams& params) noexcept {
  return params.fill || params.method == Method::kDynamicProgramming;
}

}  // namespace

Matcher::Matcher(const MatchParams& params, int width, int height, Arena& arena,
                 const ThreadTeam& team) noexcept
    : fill_(params.fill),
      continues_(params.method == Method::kDynamicProgramming),
      filled_(made_up(params) ? arena.take_image<std::uint8_t>(width, height)
                              : ImageView<std::uint8_t>()),
      searches_(params, filled_),
      matcher_(appliance_params(params).value_or(params), width, height, arena, team,
               appliance_params(params) ? nullptr : &searches_) {
  STOF_CHECK(check(params, width, height) == Status::kOk);
}

void Matcher::match(const MatchInput& input, ImageView<Disparity> out) noexcept {
  width_ = out.width();
  height_ = out.height();
  matcher_.match(input, out);
  if (filled_.empty() || out.empty()) {
    return;
  }
  const ImageView<std::uint8_t> filled = cut(filled_, width_, height_);
  for (int y = 0; y < height_ && !continues_; ++y) {
    std::ranges::fill(filled.row(y), std::uint8_t{0});
  }
  if (fill_) {
    fill_from_background(out, out.rows(), filled);
  }
  for (int y = 0; y < height_; ++y) {
    const std::span<std::uint8_t> marks = filled.row(y);
    for (std::size_t x = 0; x < marks.size(); ++x) {
      marks[x] = out.row(y)[x].valid() ? marks[x] : std::uint8_t{0};  // a check dropped it
    }
  }
}

}  // namespace stof::lab
