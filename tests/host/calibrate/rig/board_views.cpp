#include "tests/host/calibrate/rig/board_views.h"

#include <cmath>

#include "host/calibrate/rig/target/target_calibration.h"

namespace stof::host::test {

dsp::RawPair true_pair() {
  dsp::RawPair rig;
  rig.left = {.width = 640,
              .height = 480,
              .fx = 610,
              .fy = 608,
              .cx = 322.5,
              .cy = 236,
              .k1 = -0.21,
              .k2 = 0.07,
              .p1 = 0.0008,
              .p2 = -0.0006};
  rig.right = {.width = 640,
               .height = 480,
               .fx = 604,
               .fy = 605,
               .cx = 315,
               .cy = 243,
               .k1 = -0.19,
               .k2 = 0.05,
               .p1 = -0.0005,
               .p2 = 0.0007};
  rig.left_to_right = transform_of(PoseUnknowns{0.012, -0.02, 0.008, -0.12, 0.002, 0.003});
  return rig;
}

std::vector<PixelPoint> seen_in_part(const dsp::Pinhole& lens, const PoseUnknowns& board_to_camera,
                                     const Board& board, double noise_px, Gaussian& random) {
  const LensUnknowns unknowns = unknowns_of(lens);
  const Matrix3 turn = rotation_of(board_to_camera);
  std::vector<PixelPoint> seen;
  for (int i = 0; i < board.corners(); ++i) {
    const std::array<double, 2> at = board.at(i);
    const Vector3 point = turn * Vector3(at[0], at[1], 0) + translation_of(board_to_camera);
    std::array<double, 2> pixel{};
    // Far outside of its field a lens folds.
    const bool ahead =
        std::abs(point.x()) < 0.75 * point.z() && std::abs(point.y()) < 0.75 * point.z();
    const bool inside =
        ahead && project(unknowns.data(), {point.x(), point.y(), point.z()}, pixel) &&
        pixel[0] > 4 && pixel[1] > 4 && pixel[0] < lens.width - 5 && pixel[1] < lens.height - 5;
    const double off_u = random.next(noise_px);
    const double off_v = random.next(noise_px);
    seen.push_back(inside ? PixelPoint{pixel[0] + off_u, pixel[1] + off_v} : kUnseen);
  }
  return seen_corners(seen) >= std::size_t{kFewestSeen} ? seen : std::vector<PixelPoint>{};
}

std::vector<PixelPoint> seen_by(const dsp::Pinhole& lens, const PoseUnknowns& board_to_camera,
                                const Board& board, double noise_px, Gaussian& random) {
  const std::vector<PixelPoint> seen = seen_in_part(lens, board_to_camera, board, noise_px, random);
  const bool whole = seen_corners(seen) == static_cast<std::size_t>(board.corners());
  return whole ? seen : std::vector<PixelPoint>{};
}

PoseUnknowns board_at(const Board& board, const Vector3& middle, const Vector3& turn) {
  const Matrix3 rotation = rotation_of(PoseUnknowns{turn.x(), turn.y(), turn.z(), 0, 0, 0});
  const std::array<double, 2> last = board.at(board.corners() - 1);
  return pose_of(rotation, Vector3(middle - rotation * Vector3(last[0] / 2, last[1] / 2, 0)));
}

PairView view_of(const dsp::RawPair& rig, const Board& board, const PoseUnknowns& pose,
                 double noise_px, Gaussian& random) {
  const Matrix3 between = rotation_of(pose_of(rig.left_to_right));
  const PoseUnknowns in_right =
      pose_of(Matrix3(between * rotation_of(pose)),
              Vector3(between * translation_of(pose) + translation_of(pose_of(rig.left_to_right))));
  return {.name = "",
          .left = seen_by(rig.left, pose, board, noise_px, random),
          .right = seen_by(rig.right, in_right, board, noise_px, random)};
}

std::vector<PoseUnknowns> waved_poses(const dsp::RawPair& rig, const Board& board,
                                      std::size_t count, std::uint64_t seed) {
  Gaussian random(seed);
  std::vector<PoseUnknowns> poses;
  while (poses.size() < count) {
    const double z = random.between(0.36, 1.2);
    // Every fourth view is held into one of the picture's corners, which the other eye may not see.
    const std::size_t n = poses.size();
    const bool corner = n % 4 == 0;
    const double across =
        corner ? (n / 4 % 2 == 0 ? 1 : -1) * random.between(0.3, 0.5) : random.between(-0.35, 0.4);
    const double down =
        corner ? (n / 8 % 2 == 0 ? 1 : -1) * random.between(0.2, 0.4) : random.between(-0.3, 0.3);
    const Vector3 middle(across * z, down * z, z);
    const Vector3 turn(random.between(-0.6, 0.6), random.between(-0.6, 0.6),
                       random.between(-0.3, 0.3));
    const PoseUnknowns pose = board_at(board, middle, turn);
    const PairView view = view_of(rig, board, pose, 0, random);
    if (view.both() || ((!view.left.empty() || !view.right.empty()) && corner)) {
      poses.push_back(pose);
    }
  }
  return poses;
}

std::vector<PairView> waved(const dsp::RawPair& rig, const Board& board, std::size_t count,
                            double noise_px, std::uint64_t seed) {
  Gaussian random(seed + 1000);
  std::vector<PairView> views;
  for (const PoseUnknowns& pose : waved_poses(rig, board, count, seed)) {
    views.push_back(view_of(rig, board, pose, noise_px, random));
    views.back().name = std::to_string(views.size() - 1);
  }
  return views;
}

double angle_between(const dsp::RigidTransform& a, const dsp::RigidTransform& b) {
  const Matrix3 turn = rotation_of(pose_of(a)) * rotation_of(pose_of(b)).transpose();
  return Eigen::AngleAxisd(turn).angle();
}

double row_rms_of_truth(const dsp::RawPair& truth, const dsp::RawPair& rig) {
  const LensUnknowns left = unknowns_of(truth.left);
  const LensUnknowns right = unknowns_of(truth.right);
  const Matrix3 turn = rotation_of(pose_of(truth.left_to_right));
  PairView view;
  for (const double z : {0.8, 2.0, 6.0}) {
    for (int j = -20; j <= 20; ++j) {
      for (int i = -20; i <= 20; ++i) {
        const Vector3 point(z * 0.032 * i, z * 0.024 * j, z);
        const Vector3 other = turn * point + translation_of(pose_of(truth.left_to_right));
        std::array<double, 2> l{};
        std::array<double, 2> r{};
        project(left.data(), {point.x(), point.y(), point.z()}, l);
        project(right.data(), {other.x(), other.y(), other.z()}, r);
        const auto inside = [&truth](const std::array<double, 2>& p) {
          return p[0] >= 0 && p[1] >= 0 && p[0] <= truth.left.width - 1 &&
                 p[1] <= truth.left.height - 1;
        };
        if (inside(l) && inside(r)) {
          view.left.push_back({l[0], l[1]});
          view.right.push_back({r[0], r[1]});
        }
      }
    }
  }
  double squares = 0;
  for (const double row : row_errors(view, rig)) {
    squares += row * row;
  }
  return std::sqrt(squares / static_cast<double>(view.left.size()));
}

}  // namespace stof::host::test
