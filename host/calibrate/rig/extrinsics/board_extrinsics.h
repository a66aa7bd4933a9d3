#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/rig/extrinsics/extrinsic_fit.h"
#include "host/calibrate/rig/target/pair_fit.h"

// Where a PMD camera stands to a pair, from views of a board that all three cameras see whole. For
// PMD cameras whose pixels are fine enough for its corners: squares of 5 px and more.
namespace stof::host {

struct PmdBoardView {
  PairView pair;                // corners in the pictures as they are
  std::vector<PixelPoint> pmd;  // in the amplitude picture
};

// The rig whose places are kept: raw lenses, and what turns the left camera's axes into the
// rectified ones.
struct FixedPair {
  dsp::RawPair rig;
  std::array<double, 9> left_turn{1, 0, 0, 0, 1, 0, 0, 0, 1};
};
// Of a rectified pair: its own lenses.
FixedPair fixed_pair(const dsp::StereoRig& rig);

inline constexpr std::size_t kFewestBoardViews = 5;

// ExtrinsicFit: no offset; wall_misfit is each view's rms of PMD corners over what they scatter by
// in all views; misfit is how far views disagree of the PMD camera's place, squared, over what
// corners that are off independently make of it, and the covariance is of that and of what corners
// of all views share. The lenses and the pair are taken as they are: what they are uncertain by is
// not in it. None of fewer than kFewestBoardViews views, or where it does not converge.
std::optional<ExtrinsicFit> fit_extrinsics(const Board& board,
                                           const std::vector<PmdBoardView>& views,
                                           const FixedPair& pair, const dsp::Pinhole& pmd);

// Of a place by views, empty or what is wrong: views disagree as no sound lenses make them.
inline constexpr double kLargestViewMisfit = 10;
std::string contradiction_of_views(const ExtrinsicFit& fit);

// Corners in an amplitude picture (any unit) of a camera with that lens. The picture is enlarged
// for the finder. Empty: not found.
std::vector<PixelPoint> corners_in_amplitude(const dataset::Image<float>& amplitude,
                                             const dsp::Pinhole& lens, const Board& board);

}  // namespace stof::host
