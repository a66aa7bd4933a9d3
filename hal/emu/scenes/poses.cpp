#include "hal/emu/scenes/poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "dsp/base/parse_number.h"
#include "dsp/base/random.h"
#include "hal/emu/imagery/lens_rays.h"
#include "hal/emu/imagery/phasor.h"

namespace stof::hal::emu {
namespace {

constexpr std::string_view kWave = "wave:";
constexpr std::string_view kTilts = "tilts:";
constexpr std::string_view kDistances = "distances:";
constexpr double kNearestM = 0.1;
constexpr double kFarthestM = 50;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) noexcept : random_(seed) {}
  double between(double low, double high) noexcept {
    return low + (high - low) * static_cast<double>(random_.next() >> 11U) * 0x1p-53;
  }
  double either_side(double low, double high) noexcept {
    const double sign = between(-1, 1) < 0 ? -1 : 1;
    return sign * between(low, high);
  }
  // A direction in the plane x, y.
  Vec3 across() noexcept {
    const Phasor way = phasor(between(0, 1));
    return {way.re, way.im, 0};
  }

 private:
  dsp::SplitMix64 random_;
};

Vec3 middle_of(const Board& board) noexcept { return -1 * board.origin; }  // in its axes

Pose turned_by_degrees(double yaw, double pitch, double roll) noexcept {
  return turned(half_tangent(yaw), half_tangent(pitch), half_tangent(roll));
}

// The board turned, its middle at `at`.
Pose placed(const Board& board, const Pose& turn, const Vec3& at) noexcept {
  Pose out = turn;
  out.position = at - turn.turn(middle_of(board));
  return out;
}

// What a kind of the wave looks like.
struct Look {
  const char* kind;
  double least_share;  // of the picture's width that the pattern takes
  double most_share;
  double least_tilt;  // degrees, about y
  double most_tilt;
  double least_pitch;  // about x
  double most_pitch;
  double reach;  // how far from the middle, of where the picture ends; 0..1
};
constexpr std::array<Look, 5> kLooks{{{"near", 0.60, 0.80, 0, 12, 0, 12, 0.3},
                                      {"far", 0.25, 0.35, 0, 15, 0, 15, 0.9},
                                      {"tilt-y", 0.40, 0.60, 25, 45, 0, 10, 0.6},
                                      {"tilt-x", 0.40, 0.60, 0, 10, 25, 45, 0.6},
                                      {"corner", 0.28, 0.40, 0, 20, 0, 20, 1}}};

class Wave {
 public:
  Wave(const Board& board, const Rig& rig, std::uint32_t seed)
      : board_(board),
        left_(left_eye(rig)),
        right_(right_eye(rig)),
        pmd_{.lens = rig.pmd_lens, .pose = true_pmd_pose(rig)},
        draw_(dsp::mix(seed) + 0xB0A2D) {}

  BoardPose next(int number) {
    const Look& look = kLooks[static_cast<std::size_t>(number) % kLooks.size()];
    double away = 1;
    constexpr int kTries = 100;     // before it is held a little further away
    constexpr int kWithPmd = 1500;  // before the PMD camera need not see it
    constexpr int kMost = 20'000;
    Pose pose;
    for (int i = 1; i <= kMost; ++i) {
      pose = draw(look, number / static_cast<int>(kLooks.size()), away);
      if (seen(left_, pose) && seen(right_, pose) &&
          (i > kWithPmd || pmd_.lens.width == 0 || seen(pmd_, pose))) {
        break;
      }
      if (i % kTries == 0) {
        away = i == kWithPmd ? 1 : away * 1.05;
      }
    }
    return {.kind = look.kind, .pose = pose};
  }

 private:
  bool seen(const Eye& eye, const Pose& pose) const noexcept {
    return sees_pattern(eye.lens, eye.pose, board_, pose);
  }

  Pose draw(const Look& look, int round, double away) {
    const dsp::Pinhole& lens = left_.lens;
    const double share = draw_.between(look.least_share, look.most_share);
    const double z = away * lens.fx * 2 * board_.pattern_half.x / (share * lens.width);
    const Pose turn = turned_by_degrees(draw_.either_side(look.least_tilt, look.most_tilt),
                                        draw_.either_side(look.least_pitch, look.most_pitch),
                                        draw_.between(-12, 12));
    // Half of the picture less half of the pattern is how far its middle may be.
    const double half_x = std::max(0.0, (lens.width / lens.fx - share * lens.width / lens.fx) / 2);
    const double half_y =
        std::max(0.0, (lens.height / lens.fy - 2 * board_.pattern_half.y / z) / 2);
    double x = draw_.between(-look.reach, look.reach);
    double y = draw_.between(-look.reach, look.reach);
    if (look.reach == 1) {  // corner after corner
      constexpr double kLeast = 0.7;
      x = (round % 2 == 0 ? -1 : 1) * draw_.between(kLeast, 1);
      y = (round / 2 % 2 == 0 ? -1 : 1) * draw_.between(kLeast, 1);
    }
    // The middle of both pictures, at that distance.
    const Vec3 ahead = left_.pose.turn({0, 0, 1}) + right_.pose.turn({0, 0, 1});
    const Vec3 between = 0.5 * (left_.pose.position + right_.pose.position);
    const Vec3 at = between + (z / 2) * ahead + Vec3{x * half_x * z, y * half_y * z, 0};
    return placed(board_, turn, at);
  }

  const Board& board_;
  Eye left_;
  Eye right_;
  Eye pmd_;
  Draw draw_;
};

// By `angle` radians about an axis of length 1 (Rodrigues).
Pose turned_about(const Vec3& axis, double angle) noexcept {
  const Phasor p = phasor(angle / (2 * std::numbers::pi));
  const double rest = 1 - p.re;
  const Vec3& a = axis;
  return {.rotation = {p.re + a.x * a.x * rest, a.x * a.y * rest - a.z * p.im,
                       a.x * a.z * rest + a.y * p.im, a.y * a.x * rest + a.z * p.im,
                       p.re + a.y * a.y * rest, a.y * a.z * rest - a.x * p.im,
                       a.z * a.x * rest - a.y * p.im, a.z * a.y * rest + a.x * p.im,
                       p.re + a.z * a.z * rest},
          .position = {}};
}

// Unit quaternion w, x, y, z.
using Quaternion = std::array<double, 4>;

Quaternion quaternion_of(const Pose& pose) noexcept {
  const std::array<double, 9>& r = pose.rotation;
  Quaternion q{1 + r[0] + r[4] + r[8], r[7] - r[5], r[2] - r[6], r[3] - r[1]};
  if (q[0] < 0.1) {  // more than 140 degrees
    q = {r[7] - r[5], 1 + r[0] - r[4] - r[8], r[1] + r[3], r[2] + r[6]};
    if (q[1] < 0.1) {
      q = {r[2] - r[6], r[1] + r[3], 1 - r[0] + r[4] - r[8], r[5] + r[7]};
    }
    if (q[1] < 0.1 && q[2] < 0.1) {
      q = {r[3] - r[1], r[2] + r[6], r[5] + r[7], 1 - r[0] - r[4] + r[8]};
    }
  }
  const double size = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {q[0] / size, q[1] / size, q[2] / size, q[3] / size};
}

Pose turn_of(const Quaternion& q) noexcept {
  const auto [w, x, y, z] = q;
  return {.rotation = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                       2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                       2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)},
          .position = {}};
}

// COUNT,SEED.
bool parse_count(std::string_view text, PoseScript& script) {
  const std::size_t comma = text.find(',');
  if (comma == std::string_view::npos) {
    return false;
  }
  const auto count = dsp::parse_number_in<int>(text.substr(0, comma), 1, kMostPoses);
  const auto seed = dsp::parse_number<std::uint32_t>(text.substr(comma + 1));
  if (!count || !seed) {
    return false;
  }
  script.count = *count;
  script.seed = *seed;
  return true;
}

bool parse_distances(std::string_view text, PoseScript& script) {
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto z =
        dsp::parse_number_in<double>(text.substr(begin, end - begin), kNearestM, kFarthestM);
    if (!z || script.distances_m.size() == kMostPoses) {
      return false;
    }
    script.distances_m.push_back(*z);
    begin = end + 1;
  }
  script.count = static_cast<int>(script.distances_m.size());
  return true;
}

}  // namespace

std::expected<PoseScript, std::string> parse_poses(std::string_view text) {
  PoseScript script;
  bool good = false;
  if (text.starts_with(kWave)) {
    script.kind = PoseScript::Kind::kWave;
    good = parse_count(text.substr(kWave.size()), script);
  } else if (text.starts_with(kTilts)) {
    script.kind = PoseScript::Kind::kTilts;
    good = parse_count(text.substr(kTilts.size()), script);
  } else if (text.starts_with(kDistances)) {
    script.kind = PoseScript::Kind::kDistances;
    good = parse_distances(text.substr(kDistances.size()), script);
  }
  if (!good) {
    return std::unexpected(
        "--poses takes wave:COUNT,SEED, tilts:COUNT,SEED (1 to 200) or distances:Z,Z,... (0.1 to "
        "50 m), not \"" +
        std::string(text) + "\"; try --help");
  }
  return script;
}

bool sees_pattern(const dsp::Pinhole& lens, const Pose& camera, const Board& board,
                  const Pose& pose) noexcept {
  constexpr double kMargin = 3;  // px
  constexpr double kSame = 1e-6;
  const Vec3 middle = middle_of(board);
  for (const double sy : {-1.0, 0.0, 1.0}) {
    for (const double sx : {-1.0, 0.0, 1.0}) {
      const Vec3 point =
          pose.apply(middle + Vec3{sx * board.pattern_half.x, sy * board.pattern_half.y, 0});
      const Vec3 seen = camera.undo(point);
      if (seen.z < 0.05) {
        return false;
      }
      const double x = seen.x / seen.z;
      const double y = seen.y / seen.z;
      const PicturePoint at = project(lens, x, y);
      if (at.u < kMargin || at.u > lens.width - 1 - kMargin || at.v < kMargin ||
          at.v > lens.height - 1 - kMargin) {
        return false;
      }
      // Far outside of its field a lens folds.
      const Vec3 back = undistorted_ray(lens, at.u, at.v);
      if (std::abs(back.x - x) > kSame || std::abs(back.y - y) > kSame) {
        return false;
      }
    }
  }
  return true;
}

std::vector<BoardPose> poses_of(const PoseScript& script, const Board& board, const Rig& rig) {
  constexpr double kSteepest = 40;
  std::vector<BoardPose> out;
  Wave wave(board, rig, script.seed);
  Draw draw(dsp::mix(script.seed) + 0x7117);
  for (int i = 0; i < script.count; ++i) {
    switch (script.kind) {
      case PoseScript::Kind::kWave:
        out.push_back(wave.next(i));
        break;
      case PoseScript::Kind::kTilts: {
        const Pose turn =
            turned_by_degrees(draw.between(-kSteepest, kSteepest),
                              draw.between(-kSteepest, kSteepest), draw.between(-5, 5));
        out.push_back({.kind = "tilt", .pose = placed(board, turn, {0, 0, draw.between(1, 2.5)})});
        break;
      }
      case PoseScript::Kind::kDistances:
        out.push_back(
            {.kind = "distance",
             .pose = placed(board, {}, {0, 0, script.distances_m[static_cast<std::size_t>(i)]})});
        break;
    }
    out.back().velocity = script.speed_m_s * draw.across();
    out.back().turn = script.turn_degrees_s * std::numbers::pi / 180 * draw.across();
  }
  return out;
}

Pose later(const BoardPose& pose, const Board& board, double seconds) noexcept {
  const double rate = length(pose.turn);
  const Vec3 middle = pose.pose.apply(middle_of(board)) + seconds * pose.velocity;
  const Pose turn{.rotation = pose.pose.rotation, .position = {}};
  return placed(board,
                rate == 0 ? turn : turned_about((1 / rate) * pose.turn, seconds * rate) * turn,
                middle);
}

Pose between(const Pose& from, const Pose& to, double part) noexcept {
  const Quaternion a = quaternion_of(from);
  const Quaternion b = quaternion_of(to);
  double same = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    same += a[i] * b[i];
  }
  Quaternion mixed{};
  double square = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    mixed[i] = (1 - part) * a[i] + (same < 0 ? -part : part) * b[i];
    square += mixed[i] * mixed[i];
  }
  for (double& number : mixed) {
    number /= std::sqrt(square);
  }
  Pose out = turn_of(mixed);
  out.position = (1 - part) * from.position + part * to.position;
  return out;
}

}  // namespace stof::hal::emu
