#include "board/emu/board_scene.h"

#include <array>
#include <cstdio>
#include <numbers>

#include "board/emu/rig_flags.h"
#include "dsp/base/parse_number.h"

namespace stof::board {
namespace {

namespace emu = hal::emu;

// METRES or METRES,DEGREES, both a second.
bool parse_speed(std::string_view text, BoardOptions& options) {
  const std::size_t comma = text.find(',');
  const auto speed = dsp::parse_number_in<double>(text.substr(0, comma), 0, 5);
  const auto turn = comma == std::string_view::npos
                        ? std::optional(0.0)
                        : dsp::parse_number_in<double>(text.substr(comma + 1), 0, 720);
  if (!speed || !turn) {
    return false;
  }
  options.speed_m_s = *speed;
  options.turn_degrees_s = *turn;
  return true;
}

std::string folder_of(std::size_t number) {
  std::array<char, 24> name{};
  std::snprintf(name.data(), name.size(), "pose_%03zu", number);
  return name.data();
}

std::array<double, 3> numbers_of(const emu::Vec3& v) { return {v.x, v.y, v.z}; }

dataset::PoseTruth truth_of(const emu::BoardPose& pose, const emu::Board& board,
                            const emu::Rig& rig) {
  const emu::Eye left = emu::left_eye(rig);
  const emu::Eye right = emu::right_eye(rig);
  const std::array<double, 9>& r = left.pose.rotation;
  const emu::Pose to_left{.rotation = {r[0], r[3], r[6], r[1], r[4], r[7], r[2], r[5], r[8]},
                          .position = -1 * left.pose.turn_back(left.pose.position)};
  const emu::Pose seen = to_left * pose.pose;
  const bool pmd = rig.pmd_lens.width > 0;
  constexpr double kDegrees = 180 / std::numbers::pi;
  return {.folder = {},
          .kind = pose.kind,
          .board_to_left = {.rotation = seen.rotation, .translation_m = numbers_of(seen.position)},
          .velocity_m_s = numbers_of(to_left.turn(pose.velocity)),
          .turn_degrees_s = numbers_of(kDegrees * to_left.turn(pose.turn)),
          .seen_by_left = emu::sees_pattern(left.lens, left.pose, board, pose.pose),
          .seen_by_right = emu::sees_pattern(right.lens, right.pose, board, pose.pose),
          .seen_by_pmd =
              pmd && emu::sees_pattern(rig.pmd_lens, emu::true_pmd_pose(rig), board, pose.pose)};
}

const char* kind_of(const emu::Board& board) {
  switch (board.kind) {
    case emu::Board::Kind::kChess:
      return "chess";
    case emu::Board::Kind::kPrint:
      return "print";
    case emu::Board::Kind::kPlane:
      break;
  }
  return "plane";
}

emu::PoseScript script_of(const emu::Board& board, const BoardOptions& options) {
  emu::PoseScript script;
  if (options.poses) {
    script = *options.poses;
  } else if (board.kind == emu::Board::Kind::kPlane) {
    script = {.kind = emu::PoseScript::Kind::kDistances, .count = 1, .distances_m = {2}};
  }
  script.speed_m_s = options.speed_m_s;
  script.turn_degrees_s = options.turn_degrees_s;
  return script;
}

}  // namespace

std::expected<bool, std::string> take_board_flag(std::string_view flag, std::string_view value,
                                                 BoardOptions& options) {
  if (flag == "--poses") {
    std::expected<emu::PoseScript, std::string> poses = emu::parse_poses(value);
    if (!poses) {
      return std::unexpected(std::move(poses.error()));
    }
    options.poses = std::move(*poses);
  } else if (flag == "--speed") {
    if (!parse_speed(value, options)) {
      return refuse_value(flag, "M_S[,DEGREES_S], up to 5 and 720", value);
    }
  } else if (flag == "--hold" || flag == "--moves") {
    const bool hold = flag == "--hold";
    const auto count = dsp::parse_number_in<int>(value, hold ? 1 : 0, 1000);
    if (!count) {
      return refuse_value(flag, hold ? "1 to 1000 exposures" : "0 to 1000 exposures", value);
    }
    (hold ? options.hold : options.moves) = *count;
  } else {
    return false;
  }
  return true;
}

std::string_view board_usage() noexcept {
  return "  --poses SCRIPT       of a board or a plane: wave:COUNT,SEED (near, far, tilted, in the "
         "corners;\n"
         "                       default wave:20,1), tilts:COUNT,SEED, distances:Z,Z,... (metres)\n"
         "  --speed M_S[,DEG_S]  each pose is passed at so many metres and degrees a second\n"
         "  --hold N, --moves N  live: exposures at each pose (30), and on the way to the next "
         "(1)\n";
}

double board_light(std::string_view scene) noexcept {
  constexpr double kNearBoard = 0.08;
  constexpr double kNearPlane = 0.4;
  if (!emu::is_board(scene)) {
    return 1;
  }
  return scene == "plane" ? kNearPlane : kNearBoard;
}

emu::Rig board_rig() {
  emu::Rig rig = emu::corridor_rig();
  rig.left_camera_pose = {};
  return rig;
}

BoardWorld board_world(const emu::Board& board, const emu::Rig& rig, const BoardOptions& options,
                       const emu::BoardTimes& times) {
  const emu::PoseScript script = script_of(board, options);
  const std::vector<emu::BoardPose> poses = emu::poses_of(script, board, rig);
  BoardWorld world{.imagery = std::make_unique<emu::MovingScene>(
                       emu::board_motion(board, poses, rig, times), rig),
                   .truth = truth_of(rig),
                   .plane_z_m = {}};
  world.truth.board = dataset::BoardTruth{.kind = kind_of(board),
                                          .columns = board.columns,
                                          .rows = board.rows,
                                          .square_m = board.square_m};
  for (std::size_t i = 0; i < poses.size(); ++i) {
    world.truth.poses.push_back(truth_of(poses[i], board, rig));
    world.truth.poses.back().folder = folder_of(i);
    const bool known = script.kind == emu::PoseScript::Kind::kDistances;
    world.plane_z_m.push_back(known ? std::optional(script.distances_m[i]) : std::nullopt);
  }
  return world;
}

}  // namespace stof::board
