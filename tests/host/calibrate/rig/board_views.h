#pragma once

#include <vector>

#include "host/calibrate/rig/target/pair_fit.h"
#include "tests/host/calibrate/rig/gaussian.h"

// Views of a board as points, without pictures.
namespace stof::host::test {

// A pair with distortion, a baseline of 12 cm and cameras turned against each other by some
// degrees.
dsp::RawPair true_pair();

// What an eye sees of a board: its corners with noise, or none where it does not see all of them.
std::vector<PixelPoint> seen_by(const dsp::Pinhole& lens, const PoseUnknowns& board_to_camera,
                                const Board& board, double noise_px, Gaussian& random);

// The same of a board with markers: its corners in the picture, the others kUnseen; none where they
// are fewer than kFewestSeen.
std::vector<PixelPoint> seen_in_part(const dsp::Pinhole& lens, const PoseUnknowns& board_to_camera,
                                     const Board& board, double noise_px, Gaussian& random);

// A board at a place (metres, left camera's axes) of its middle, turned by rotation vector.
PoseUnknowns board_at(const Board& board, const Vector3& middle, const Vector3& turn);

PairView view_of(const dsp::RawPair& rig, const Board& board, const PoseUnknowns& pose,
                 double noise_px, Gaussian& random);

// Poses of a usual set of views, to the left camera: of each the board is whole in both pictures,
// of every fourth in one at least.
std::vector<PoseUnknowns> waved_poses(const dsp::RawPair& rig, const Board& board,
                                      std::size_t count, std::uint64_t seed);
// Such views: near and far, tilted to all sides, all over the picture.
std::vector<PairView> waved(const dsp::RawPair& rig, const Board& board, std::size_t count,
                            double noise_px, std::uint64_t seed);

// Radians.
double angle_between(const dsp::RigidTransform& a, const dsp::RigidTransform& b);

// How far rows are apart that `rig` makes correspond, px rms: of points without noise all over the
// left picture of `truth` to its corners, 0.8 to 6 m away, where the right camera sees them too.
double row_rms_of_truth(const dsp::RawPair& truth, const dsp::RawPair& rig);

}  // namespace stof::host::test
