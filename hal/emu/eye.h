#pragma once

#include <vector>

#include "hal/emu/scene.h"

namespace stof::hal::emu {

// One viewpoint of a scene. Rays are given as (x, y) for the direction (x, y, 1) of the eye's
// frame, so that Hit::t is the depth Z. The scene must outlive it.
class Eye {
 public:
  Eye(const Scene& scene, const Pose& pose);

  const Pose& pose() const noexcept { return pose_; }
  // The nearest thing.
  Hit look(double x, double y) const noexcept;
  // The same if `thing` were alone in the world.
  Hit look_at(int thing, double x, double y) const noexcept;

 private:
  // A thing as seen from here: things outside their bounds in (x, y) need no intersection.
  struct Seen {
    Vec3 origin;  // of the eye, in the thing's frame
    Pose turn;    // from the eye's frame into the thing's; rotation only
    double x_min;
    double x_max;
    double y_min;
    double y_max;
  };
  Hit complete(int thing, const LocalHit& local, const Vec3& direction) const noexcept;

  const Scene& scene_;
  Pose pose_;
  std::vector<Seen> seen_;
};

}  // namespace stof::hal::emu
