#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "dsp/calib/pinhole.h"
#include "hal/emu/scenes/intersect.h"
#include "hal/emu/scenes/scene.h"

namespace stof::hal::emu {

// Pixels begin .. end - 1 of a row; none where end <= begin.
struct Run {
  int begin = 0;
  int end = 0;
  friend constexpr bool operator==(const Run&, const Run&) noexcept = default;
};

// One viewpoint of a scene. Rays are given as (x, y) for the direction (x, y, 1) of the viewpoint's
// frame, so that Hit::t is the depth Z. The scene must outlive it.
class Viewpoint {
 public:
  Viewpoint(const Scene& scene, const Pose& pose);

  const Pose& pose() const noexcept { return pose_; }
  int objects() const noexcept { return static_cast<int>(seen_.size()); }
  // The nearest object.
  Hit look(double x, double y) const noexcept { return look_past(-1, x, y); }
  // The same if `absent` were not there.
  Hit look_past(int absent, double x, double y) const noexcept;
  // The same if `object` were alone in the world.
  Hit look_at(int object, double x, double y) const noexcept;

  // No ray outside meets the object. May be infinite.
  struct Window {
    double x_min;
    double x_max;
    double y_min;
    double y_max;
    constexpr bool holds(double x, double y) const noexcept {
      return x >= x_min && x <= x_max && y >= y_min && y <= y_max;
    }
  };
  const Window& window(int object) const noexcept {
    return seen_[static_cast<std::size_t>(object)].window;
  }
  // Whether object `first` or a later one may be seen within the part of the field.
  bool may_show(int first, const Window& part) const noexcept;

 private:
  // An object as seen from here.
  struct Seen {
    Vec3 origin;  // of the viewpoint, in the object's frame
    Pose turn;    // from the viewpoint's frame into the object's; rotation only
    Window window;
  };
  Hit complete(int object, const LocalHit& local, const Vec3& direction) const noexcept;
  void note_cells(std::size_t object);
  std::span<const std::uint64_t> candidates(double x, double y) const noexcept;

  const Scene& scene_;
  Pose pose_;
  std::vector<Seen> seen_;
  // For cells of rays, row by row: one bit for each object whose window reaches into the cell. The
  // last entry is for rays outside of all cells: every object.
  std::vector<std::uint64_t> cells_;
  std::size_t words_;  // of an entry
};

// The pixels of each row, from the first to the last, into which object `first` or a later one may
// reach: all others look the same without these objects. For a lens without distortion.
std::vector<Run> runs_of_objects(const Viewpoint& viewpoint, const dsp::Pinhole& lens, int first);
// The same for any lens; rays: of the pixel centres, row by row; blurred: by how many pixels a
// pixel's light is spread at most.
std::vector<Run> runs_of_objects(const Viewpoint& viewpoint, const dsp::Pinhole& lens,
                                 std::span<const Vec3> rays, int first, int blurred = 0);
// Runs of which each pixel has `reach` more on all four sides, within `width` columns and as many
// rows as there are.
std::vector<Run> grown(const std::vector<Run>& runs, int width, int reach);
// Every pixel.
std::vector<Run> whole_picture(const dsp::Pinhole& lens);

}  // namespace stof::hal::emu
