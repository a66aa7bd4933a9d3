#include "dsp/depth/depth_maker.h"

#include "dsp/base/arena_phase.h"
#include "dsp/base/check.h"

namespace stof::dsp {
namespace {

// Rows that a thread rectifies or fuses at once: a row looks at few others.
constexpr int kTaskRows = 16;
constexpr int kTaskCells = 2;  // rows of cells

constexpr double kMetresPerQuarterMm = 1.0 / kQuarterMmPerMetre;

bool has_pmd(const Calibration& calibration) noexcept { return calibration.pmd.lens.width > 0; }

bool guides(const Calibration& calibration, const DepthParams& params) noexcept {
  return params.guided && GuideMaker::serves(calibration);
}

bool unwraps(const Calibration& calibration, const DepthParams& params) noexcept {
  return has_pmd(calibration) && Unwrapper::needed(calibration.pmd, params.fusion);
}

// What the search is asked for, with what the other parts need of it.
MatchParams search(const Calibration& calibration, const DepthParams& params) noexcept {
  MatchParams match = params.match;
  match.guided = guides(calibration, params);
  return match;
}

GuideParams guide_params(const Calibration& calibration, const DepthParams& params) noexcept {
  GuideParams guide;
  guide.farthest_m =
      unwraps(calibration, params) ? params.fusion.max_range * kMetresPerQuarterMm : 0;
  return guide;
}

}  // namespace

// What lives when: a frame has four phases, one after the other, that share what they take in
// passing. Each leaves behind:
//   guide    which candidates each pixel has
//   match    disparities, their peak ratio, and weak ones
//   unwrap   the converter's maps, with wrap counts
//   fuse     the caller's images
// Pictures, the PMD's maps and all that is remembered from frame to frame last.
DepthMaker::DepthMaker(const Calibration& calibration, const DepthParams& params, Arena& arena,
                       const ThreadTeam& team, SearchMaker* searches) noexcept
    : team_(team),
      matcher_(search(calibration, params), calibration.stereo.left.width,
               calibration.stereo.left.height, ArenaPhase(arena), team, searches),
      fuser_(calibration, params.fusion, params.match.min_disparity, params.match.disparities,
             calibration.stereo.left.width, calibration.stereo.left.height, ArenaPhase(arena),
             team.threads()) {
  const int w = calibration.stereo.left.width;
  const int h = calibration.stereo.left.height;
  const MatchParams& match = params.match;
  disparity_ = arena.take_image<Disparity>(w, h);
  if (calibration.stereo.raw) {
    rectifier_.emplace(calibration.stereo, arena);
  }
  if (guides(calibration, params)) {
    guide_maker_.emplace(calibration, guide_params(calibration, params), match.min_disparity,
                         match.disparities, w, h, ArenaPhase(arena));
  }
  if (has_pmd(calibration)) {
    converter_.emplace(calibration.pmd, arena, params.temporal);
    monitor_.emplace(calibration, DriftParams{}, arena);
  }
  if (unwraps(calibration, params)) {
    unwrapper_.emplace(calibration, params.fusion, match.min_disparity, match.disparities, w, h,
                       ArenaPhase(arena), params.temporal);
  }
  if (params.temporal) {
    past_.emplace(w, h, params.fusion.max_range, arena, team.threads());
  }
}

void DepthMaker::convert(const PmdFrame& frame) noexcept {
  STOF_CHECK(converter_.has_value());
  // A guide needs intervals before wrap counts are known.
  pmd_ = unwrapper_ && !guide_maker_ ? &converter_->measure(frame) : &converter_->convert(frame);
  unresolved_ = unwrapper_.has_value();
  unwatched_ = true;
}

void DepthMaker::match(ImageView<const std::uint8_t> left,
                       ImageView<const std::uint8_t> right) noexcept {
  const Guide guide = guide_maker_ && pmd_ != nullptr ? guide_maker_->make(*pmd_) : Guide{};
  left_ = left;
  right_ = right;
  if (rectifier_) {
    team_.run_rows(disparity_.rows(), kTaskRows,
                   [&](Rows rows, int) noexcept { rectifier_->rectify(left, right, rows); });
    left_ = rectifier_->left();
    right_ = rectifier_->right();
  }
  matcher_.match({.left = left_,
                  .right = right_,
                  .guide = guide,
                  .rectifier = rectifier_ ? &*rectifier_ : nullptr},
                 disparity_);
}

void DepthMaker::forget_pair() noexcept {
  left_ = {};
  right_ = {};
  unwatched_ = false;
}

StereoMaps DepthMaker::stereo() const noexcept {
  return left_.empty() ? StereoMaps{}
                       : StereoMaps{disparity_, matcher_.ratio(), matcher_.weak(), left_};
}

void DepthMaker::forget_past() noexcept {
  if (past_) {
    past_->forget();
    forget_readings();
  }
}

void DepthMaker::look() noexcept {
  past_->look(left_);
  if (past_->frames() <= 1) {  // a gap, or the camera moved
    forget_readings();
  }
}

void DepthMaker::forget_readings() noexcept {
  if (converter_) {
    converter_->forget_past();
  }
  if (unwrapper_) {
    unwrapper_->forget_past();
  }
}

void DepthMaker::fuse(const DepthMap& out, std::int32_t pmd_lag_us) noexcept {
  if (unresolved_ && pmd_ != nullptr) {
    unwrapper_->resolve(*pmd_, stereo().disparity);
    unresolved_ = false;
  }
  pmd_lag_us_ = pmd_lag_us;
  fuser_.prepare(pmd_, pmd_lag_us);
  team_.run_rows(out.depth.rows(), kTaskRows, [&](Rows rows, int thread) noexcept {
    fuser_.fuse_rows(stereo(), rows, thread, out);
  });
  const bool fills = fuser_.fills_holes(stereo(), out);
  if (fills) {
    team_.run_rows(fuser_.cell_rows(), kTaskCells,
                   [&](Rows cells, int) noexcept { fuser_.gather_surfaces(cells, out); });
  }
  if (past_) {
    look();
  }
  if (fills || past_) {
    // Together, while rows are near.
    team_.run_rows(fuser_.cell_rows(), kTaskCells, [&](Rows cells, int thread) noexcept {
      if (fills) {
        fuser_.fill_holes(stereo(), cells, out);
      }
      if (past_ && past_->filters()) {
        const Rows rows = fuser_.map_rows(cells);
        for (int y = rows.begin; y < rows.end; ++y) {
          past_->filter(y, thread, fuser_.intervals(stereo(), y, thread), out);
        }
      }
    });
  }
}

void DepthMaker::watch(std::int32_t since_us) noexcept {
  if (!monitor_ || left_.empty()) {
    return;
  }
  monitor_->follow(left_, since_us);
  if (unwatched_ && pmd_ != nullptr) {
    monitor_->observe({.left = left_, .right = right_, .disparity = disparity_}, *pmd_,
                      pmd_lag_us_);
    unwatched_ = false;
  }
}

DriftEstimate DepthMaker::drift() const noexcept {
  return monitor_ ? monitor_->estimate() : DriftEstimate{};
}

}  // namespace stof::dsp
