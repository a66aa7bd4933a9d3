#include "lab/matcher.h"

#include <algorithm>

#include "dsp/base/check.h"
#include "dsp/base/index.h"
#include "lab/fill.h"
#include "lab/weighted_median.h"

namespace stof::lab {
namespace {

bool made_up(const MatchParams& params) noexcept {
  return params.fill || params.method == Method::kDynamicProgramming;
}

// Filling asks which matches were weak.
MatchParams with_weak(MatchParams params) noexcept {
  params.confidence = params.confidence || (params.fill && (params.distinct || params.min_texture));
  return params;
}

}  // namespace

Matcher::Matcher(const MatchParams& params, int width, int height, Arena& arena,
                 const ThreadTeam& team) noexcept
    : filler_(params.fill ? std::optional(Filler(width, height, arena)) : std::nullopt),
      copy_(params.fill ? arena.take_image<Disparity>(width, height) : ImageView<Disparity>()),
      continues_(params.method == Method::kDynamicProgramming),
      filled_(made_up(params) ? arena.take_image<std::uint8_t>(width, height)
                              : ImageView<std::uint8_t>()),
      searches_(params, filled_),
      matcher_(appliance_params(with_weak(params)).value_or(with_weak(params)), width, height,
               arena, team, appliance_params(params) ? nullptr : &searches_) {
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
  if (filler_) {
    make_dense(input.left, out, filled);
  }
  for (int y = 0; y < height_; ++y) {
    const std::span<std::uint8_t> marks = filled.row(y);
    for (std::size_t x = 0; x < marks.size(); ++x) {
      marks[x] = out.row(y)[x].valid() ? marks[x] : std::uint8_t{0};  // a check dropped it
    }
  }
}

void Matcher::make_dense(ImageView<const std::uint8_t> grey, ImageView<Disparity> out,
                         ImageView<std::uint8_t> filled) noexcept {
  // Where nothing was sure, what is weak is made of noise or of nothing.
  bool any = false;
  for (int y = 0; y < height_ && !any; ++y) {
    any = std::ranges::any_of(out.row(y), &Disparity::valid);
  }
  for (int y = 0; any && y < height_ && !matcher_.weak().empty(); ++y) {
    for (std::size_t x = 0; x < index(width_); ++x) {
      if (!out.row(y)[x].valid() && matcher_.weak().row(y)[x].valid()) {
        out.row(y)[x] = matcher_.weak().row(y)[x];
        filled.row(y)[x] = 1;
      }
    }
  }
  filler_->fill(out, filled);
  const ImageView<Disparity> copy = cut(copy_, width_, height_);
  weighted_median(grey, out, copy);
  weighted_median(grey, copy, out);
}

}  // namespace stof::lab
