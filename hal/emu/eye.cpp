#include "hal/emu/eye.h"

#include <algorithm>
#include <limits>

namespace stof::hal::emu {
namespace {

constexpr double kBehind = 0.01;  // metres: a thing that reaches nearer has no bounds
constexpr double kEverywhere = std::numeric_limits<double>::infinity();

}  // namespace

Eye::Eye(const Scene& scene, const Pose& pose) : scene_(scene), pose_(pose) {
  for (const Thing& thing : scene.things) {
    Pose turn;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          sum += thing.pose.rotation[3 * k + i] * pose.rotation[3 * k + j];
        }
        turn.rotation[3 * i + j] = sum;
      }
    }
    Seen seen{.origin = thing.pose.undo(pose.position),
              .turn = turn,
              .x_min = kEverywhere,
              .x_max = -kEverywhere,
              .y_min = kEverywhere,
              .y_max = -kEverywhere};
    const double depth = thing.form == Form::kRectangle ? 0 : thing.half.z;
    for (const double x : {-thing.half.x, thing.half.x}) {
      for (const double y : {-thing.half.y, thing.half.y}) {
        for (const double z : {-depth, depth}) {
          const Vec3 corner = pose.undo(thing.pose.apply({x, y, z}));
          const bool bounded = corner.z > kBehind;
          seen.x_min = std::min(seen.x_min, bounded ? corner.x / corner.z : -kEverywhere);
          seen.x_max = std::max(seen.x_max, bounded ? corner.x / corner.z : kEverywhere);
          seen.y_min = std::min(seen.y_min, bounded ? corner.y / corner.z : -kEverywhere);
          seen.y_max = std::max(seen.y_max, bounded ? corner.y / corner.z : kEverywhere);
        }
      }
    }
    seen_.push_back(seen);
  }
}

Hit Eye::look(double x, double y) const noexcept {
  const Vec3 direction{x, y, 1};
  LocalHit nearest;
  int thing = -1;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Seen& seen = seen_[i];
    if (x < seen.x_min || x > seen.x_max || y < seen.y_min || y > seen.y_max) {
      continue;
    }
    const Thing& candidate = scene_.things[i];
    const LocalHit hit =
        intersect(candidate.form, candidate.half, seen.origin, seen.turn.turn(direction));
    if (hit.t > 0 && (thing < 0 || hit.t < nearest.t)) {
      nearest = hit;
      thing = static_cast<int>(i);
    }
  }
  return complete(thing, nearest, direction);
}

Hit Eye::look_at(int thing, double x, double y) const noexcept {
  const Vec3 direction{x, y, 1};
  const std::size_t i = static_cast<std::size_t>(thing);
  const LocalHit hit = intersect(scene_.things[i].form, scene_.things[i].half, seen_[i].origin,
                                 seen_[i].turn.turn(direction));
  return complete(hit.t > 0 ? thing : -1, hit, direction);
}

Hit Eye::complete(int thing, const LocalHit& local, const Vec3& direction) const noexcept {
  if (thing < 0) {
    return {};
  }
  const std::size_t i = static_cast<std::size_t>(thing);
  return {.t = local.t,
          .thing = thing,
          .face = local.face,
          .point = pose_.apply(local.t * direction),
          .normal = scene_.things[i].pose.turn(local.normal),
          .local = seen_[i].origin + local.t * seen_[i].turn.turn(direction)};
}

}  // namespace stof::hal::emu
