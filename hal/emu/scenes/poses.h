#pragma once

#include <cstdint>
#include <expected>
#include <string>
#include <string_view>
#include <vector>

#include "hal/emu/scenes/boards.h"
#include "hal/emu/scenes/rig.h"

// Scripts of what somebody who calibrates a rig holds before it.
namespace stof::hal::emu {

// In the axes of Rig::stereo.
struct BoardPose {
  std::string kind;  // what it is meant to show: near, far, tilt-x, tilt-y, corner; tilt, distance
  Pose pose{};       // of the board, in the middle of the pair's exposure
  Vec3 velocity{};   // metres a second
  Vec3 turn{};       // radians a second about an axis through the middle of the sheet
};

// wave:COUNT,SEED    a board near, far, tilted about x and about y, and in the picture's corners,
// in
//                    turns; both eyes see all of its pattern, the PMD camera where it can
// tilts:COUNT,SEED   1 to 2.5 m away, tilted by up to 40 degrees
// distances:Z,Z,...  perpendicular to z, so many metres away
struct PoseScript {
  enum class Kind : std::uint8_t { kWave, kTilts, kDistances };
  Kind kind = Kind::kWave;
  int count = 20;
  std::uint32_t seed = 1;
  std::vector<double> distances_m{};
  double speed_m_s = 0;  // of each pose, in a direction of its own across the line of sight
  double turn_degrees_s = 0;
};
inline constexpr int kMostPoses = 200;

std::expected<PoseScript, std::string> parse_poses(std::string_view text);

// The poses of a script. The same for the same rig, board and script.
std::vector<BoardPose> poses_of(const PoseScript& script, const Board& board, const Rig& rig);

// Where the board of a pose is some seconds later.
Pose later(const BoardPose& pose, const Board& board, double seconds) noexcept;

// Part of the way from one pose to another, 0..1.
Pose between(const Pose& from, const Pose& to, double part) noexcept;

// Whether the camera, whose axes have that pose in the axes of Rig::stereo, sees the whole pattern.
bool sees_pattern(const dsp::Pinhole& lens, const Pose& camera, const Board& board,
                  const Pose& pose) noexcept;

}  // namespace stof::hal::emu
