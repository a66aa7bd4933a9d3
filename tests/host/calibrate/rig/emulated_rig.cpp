#include "tests/host/calibrate/rig/emulated_rig.h"

#include <string_view>

#include <gtest/gtest.h>

#include "board/emu/scenes.h"
#include "board/emu/write_pair.h"
#include "dsp/calib/stereo/rectification.h"
#include "host/calibrate/rig/target/lens_model.h"

namespace stof::host::test {

bool emulate(const std::filesystem::path& folder, const EmulatorFlags& flags) {
  const std::string to = folder.string();
  std::vector<std::string_view> words{to};
  words.insert(words.end(), flags.begin(), flags.end());
  return board::write_pair(words) == 0;
}

dataset::CalibrationTruth truth_of(const EmulatorFlags& flags) {
  board::SceneOptions options;
  for (std::size_t i = 0; i + 1 < flags.size(); i += 2) {
    EXPECT_TRUE(board::take_scene_flag(flags[i], flags[i + 1], options));
  }
  const std::expected<hal::emu::Rig, std::string> rig = board::seen_rig(options);
  EXPECT_TRUE(rig) << rig.error();
  return board::truth_of(*rig);
}

dsp::RawPair pair_of(const dataset::CalibrationTruth& truth) {
  return {.left = truth.left, .right = truth.right, .left_to_right = truth.left_to_right};
}

dsp::RigidTransform pmd_to_rectified(const dataset::CalibrationTruth& truth) {
  const dsp::Rectification rectified = dsp::rectify(pair_of(truth));
  const Matrix3 turn =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rectified.left_turn.data());
  const PoseUnknowns to_left = pose_of(truth.pmd_to_left);
  return transform_of(
      pose_of(Matrix3(turn * rotation_of(to_left)), Vector3(turn * translation_of(to_left))));
}

}  // namespace stof::host::test
