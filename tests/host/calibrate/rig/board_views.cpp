#include "tests/host/calibrate/rig/board_views.h"

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

std::vector<PixelPoint> seen_by(const dsp::Pinhole& lens, const PoseUnknowns& board_to_camera,
                                const Board& board, double noise_px, Gaussian& random) {
  const LensUnknowns unknowns = unknowns_of(lens);
  const Matrix3 turn = rotation_of(board_to_camera);
  std::vector<PixelPoint> seen;
  bool whole = true;
  for (int i = 0; i < board.corners(); ++i) {
    const std::array<double, 2> at = board.at(i);
    const Vector3 point = turn * Vector3(at[0], at[1], 0) + translation_of(board_to_camera);
    std::array<double, 2> pixel{};
    whole = whole && project(unknowns.data(), {point.x(), point.y(), point.z()}, pixel) &&
            pixel[0] > 4 && pixel[1] > 4 && pixel[0] < lens.width - 5 && pixel[1] < lens.height - 5;
    seen.push_back({pixel[0] + random.next(noise_px), pixel[1] + random.next(noise_px)});
  }
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

}  // namespace stof::host::test
