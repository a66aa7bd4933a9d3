#include "hal/emu/imagery/board_motion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "dsp/base/check.h"

namespace stof::hal::emu {
namespace {

constexpr int kMostParts = 16;
constexpr int kMostPartsOnTheWay = 4;  // nobody measures there

class BoardMotion {
 public:
  BoardMotion(const Board& board, const Rig& rig, const BoardTimes& times)
      : board_(board), times_(times.exposures), world_(rig.left_camera_pose) {
    motion_.background = behind(board);
    for (SceneObject& object : motion_.background.objects) {
      object.pose = world_ * object.pose;
    }
    for (Light& light : motion_.background.lights) {
      light.position = world_.apply(light.position);
    }
    motion_.pmd_every = times_.pmd_every;
    focal_ = left_eye(rig).lens.fx;
  }

  // Where the board is, seconds before and after the middle of the pair's exposure.
  // most_parts: 0: it stands still.
  template <typename Where>
  void add(const Where& where, int most_parts, bool samples) {
    motion_.poses.push_back({board_at(board_, world_ * where(0.0))});
    WhileExposed& during = motion_.blurred.emplace_back();
    if (most_parts == 0) {
      return;
    }
    const int parts = parts_of(where(-times_.pair / 2), where(times_.pair / 2), most_parts);
    for (int i = 0; i < parts; ++i) {
      const double at = times_.pair * ((i + 0.5) / parts - 0.5);
      during.pair.push_back({board_at(board_, world_ * where(at))});
    }
    for (std::size_t k = 0; samples && k < during.samples.size(); ++k) {
      const double at = times_.pmd * (2 * static_cast<double>(k) + 1) / 8 - times_.pair / 2;
      during.samples[k] = {board_at(board_, world_ * where(at))};
    }
  }

  void show_last(int exposures) {
    motion_.schedule.insert(motion_.schedule.end(), static_cast<std::size_t>(exposures),
                            motion_.poses.size() - 1);
  }

  Motion take() { return std::move(motion_); }

 private:
  int parts_of(const Pose& begin, const Pose& end, int most_parts) const noexcept {
    constexpr int kLeast = 2;
    double most = 0;  // px
    for (const double sy : {-1.0, 1.0}) {
      for (const double sx : {-1.0, 1.0}) {
        const Vec3 corner =
            Vec3{sx * board_.pattern_half.x, sy * board_.pattern_half.y, 0} - board_.origin;
        const Vec3 from = begin.apply(corner);
        const Vec3 to = end.apply(corner);
        const double z = std::max(std::min(from.z, to.z), 0.05);
        most = std::max(most, focal_ * length(to - from) / z);
      }
    }
    return std::clamp(static_cast<int>(std::ceil(2 * most)), kLeast, most_parts);
  }

  const Board& board_;
  ExposureTimes times_;
  Pose world_;
  double focal_ = 1;
  Motion motion_;
};

}  // namespace

Motion board_motion(const Board& board, const std::vector<BoardPose>& poses, const Rig& rig,
                    const BoardTimes& times) {
  STOF_CHECK(!poses.empty() && times.hold >= 1 && times.moves >= 0);
  BoardMotion motion(board, rig, times);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const BoardPose& pose = poses[i];
    const bool moves = length(pose.velocity) > 0 || length(pose.turn) > 0;
    motion.add([&](double seconds) { return later(pose, board, seconds); }, moves ? kMostParts : 0,
               true);
    motion.show_last(times.hold);
    const Pose& next = poses[(i + 1) % poses.size()].pose;
    const double way_s = (times.moves + 1) * times.exposures.period;
    for (int k = 1; k <= times.moves && poses.size() > 1; ++k) {
      const double part = static_cast<double>(k) / (times.moves + 1);
      motion.add([&](double seconds) { return between(pose.pose, next, part + seconds / way_s); },
                 kMostPartsOnTheWay, false);
      motion.show_last(1);
    }
  }
  return motion.take();
}

}  // namespace stof::hal::emu
