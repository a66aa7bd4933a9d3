#include "hal/emu/scenes/viewpoint.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace stof::hal::emu {
namespace {

constexpr double kBehind = 0.01;  // metres: an object that reaches nearer has no bounds
constexpr double kEverywhere = std::numeric_limits<double>::infinity();
constexpr int kCells = 64;  // a side, for rays from -1 to 1
constexpr int kBits = 64;   // of a word

double cell(double ray) noexcept { return std::floor((ray + 1) * (kCells * 0.5)); }

}  // namespace

Viewpoint::Viewpoint(const Scene& scene, const Pose& pose)
    : scene_(scene), pose_(pose), words_((scene.objects.size() + kBits - 1) / kBits) {
  cells_.resize(words_ * (kCells * kCells + 1));
  for (const SceneObject& object : scene.objects) {
    Pose turn;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          sum += object.pose.rotation[3 * k + i] * pose.rotation[3 * k + j];
        }
        turn.rotation[3 * i + j] = sum;
      }
    }
    Seen seen{.origin = object.pose.undo(pose.position),
              .turn = turn,
              .window = {.x_min = kEverywhere,
                         .x_max = -kEverywhere,
                         .y_min = kEverywhere,
                         .y_max = -kEverywhere}};
    Window& window = seen.window;
    const double depth = object.shape == Shape::kRectangle ? 0 : object.half.z;
    for (const double x : {-object.half.x, object.half.x}) {
      for (const double y : {-object.half.y, object.half.y}) {
        for (const double z : {-depth, depth}) {
          const Vec3 corner = pose.undo(object.pose.apply({x, y, z}));
          const bool bounded = corner.z > kBehind;
          window.x_min = std::min(window.x_min, bounded ? corner.x / corner.z : -kEverywhere);
          window.x_max = std::max(window.x_max, bounded ? corner.x / corner.z : kEverywhere);
          window.y_min = std::min(window.y_min, bounded ? corner.y / corner.z : -kEverywhere);
          window.y_max = std::max(window.y_max, bounded ? corner.y / corner.z : kEverywhere);
        }
      }
    }
    seen_.push_back(seen);
    note_cells(seen_.size() - 1);
  }
}

void Viewpoint::note_cells(std::size_t object) {
  const std::size_t word = object / kBits;
  const std::uint64_t bit = std::uint64_t{1} << (object % kBits);
  const Window& window = seen_[object].window;
  // What lies beyond the cells is noted at their border, where it does no harm.
  const auto nearest = [](double ray) {
    return static_cast<int>(std::clamp(cell(ray), 0.0, kCells - 1.0));
  };
  for (int y = nearest(window.y_min); y <= nearest(window.y_max); ++y) {
    for (int x = nearest(window.x_min); x <= nearest(window.x_max); ++x) {
      cells_[static_cast<std::size_t>(y * kCells + x) * words_ + word] |= bit;
    }
  }
  cells_[static_cast<std::size_t>(kCells * kCells) * words_ + word] |= bit;
}

std::span<const std::uint64_t> Viewpoint::candidates(double x, double y) const noexcept {
  const double column = cell(x);
  const double row = cell(y);
  const bool inside = column >= 0 && column < kCells && row >= 0 && row < kCells;
  const int entry =
      inside ? static_cast<int>(row) * kCells + static_cast<int>(column) : kCells * kCells;
  return std::span(cells_).subspan(static_cast<std::size_t>(entry) * words_, words_);
}

Hit Viewpoint::look_past(int absent, double x, double y) const noexcept {
  const Vec3 direction{x, y, 1};
  LocalHit nearest;
  int object = -1;
  std::size_t base = 0;
  for (std::uint64_t word : candidates(x, y)) {
    for (; word != 0; word &= word - 1) {
      const std::size_t i = base + static_cast<std::size_t>(std::countr_zero(word));
      const Seen& seen = seen_[i];
      if (!seen.window.holds(x, y) || static_cast<int>(i) == absent) {
        continue;
      }
      const SceneObject& candidate = scene_.objects[i];
      const LocalHit hit =
          intersect(candidate.shape, candidate.half, seen.origin, seen.turn.turn(direction));
      if (hit.t > 0 && (object < 0 || hit.t < nearest.t)) {
        nearest = hit;
        object = static_cast<int>(i);
      }
    }
    base += kBits;
  }
  return complete(object, nearest, direction);
}

bool Viewpoint::may_show(int first, const Window& part) const noexcept {
  for (std::size_t i = static_cast<std::size_t>(std::max(first, 0)); i < seen_.size(); ++i) {
    const Window& window = seen_[i].window;
    if (part.x_min <= window.x_max && part.x_max >= window.x_min && part.y_min <= window.y_max &&
        part.y_max >= window.y_min) {
      return true;
    }
  }
  return false;
}

Hit Viewpoint::look_at(int object, double x, double y) const noexcept {
  const Vec3 direction{x, y, 1};
  const std::size_t i = static_cast<std::size_t>(object);
  const LocalHit hit = intersect(scene_.objects[i].shape, scene_.objects[i].half, seen_[i].origin,
                                 seen_[i].turn.turn(direction));
  return complete(hit.t > 0 ? object : -1, hit, direction);
}

Hit Viewpoint::complete(int object, const LocalHit& local, const Vec3& direction) const noexcept {
  if (object < 0) {
    return {};
  }
  const std::size_t i = static_cast<std::size_t>(object);
  return {.t = local.t,
          .object = object,
          .face = local.face,
          .point = pose_.apply(local.t * direction),
          .normal = scene_.objects[i].pose.turn(local.normal),
          .local = seen_[i].origin + local.t * seen_[i].turn.turn(direction)};
}

namespace {

// A pixel's rays start within half a pixel of its centre; an undistorted one may be wider.
constexpr double kReach = 1;
constexpr double kReachDistorted = 2;

int clamped(double pixel, int size) noexcept {
  return static_cast<int>(std::clamp(pixel, 0.0, static_cast<double>(size)));
}

void widen(Run& run, int begin, int end) noexcept {
  run = run.end <= run.begin ? Run{begin, end}
                             : Run{std::min(run.begin, begin), std::max(run.end, end)};
}

}  // namespace

std::vector<Run> runs_of_objects(const Viewpoint& viewpoint, const dsp::Pinhole& lens, int first) {
  std::vector<Run> runs(static_cast<std::size_t>(lens.height));
  for (int object = first; object < viewpoint.objects(); ++object) {
    const Viewpoint::Window& window = viewpoint.window(object);
    const int begin = clamped(std::floor(window.x_min * lens.fx + lens.cx - kReach), lens.width);
    const int end = clamped(std::ceil(window.x_max * lens.fx + lens.cx + kReach) + 1, lens.width);
    const int top = clamped(std::floor(window.y_min * lens.fy + lens.cy - kReach), lens.height);
    const int bottom =
        clamped(std::ceil(window.y_max * lens.fy + lens.cy + kReach) + 1, lens.height);
    for (int y = top; y < bottom && begin < end; ++y) {
      widen(runs[static_cast<std::size_t>(y)], begin, end);
    }
  }
  return runs;
}

std::vector<Run> runs_of_objects(const Viewpoint& viewpoint, const dsp::Pinhole& lens,
                                 std::span<const Vec3> rays, int first, int blurred) {
  std::vector<Run> runs(static_cast<std::size_t>(lens.height));
  const double dx = kReachDistorted * (1 + blurred) / lens.fx;
  const double dy = kReachDistorted * (1 + blurred) / lens.fy;
  for (int object = first; object < viewpoint.objects(); ++object) {
    const Viewpoint::Window& seen = viewpoint.window(object);
    const Viewpoint::Window window{.x_min = seen.x_min - dx,
                                   .x_max = seen.x_max + dx,
                                   .y_min = seen.y_min - dy,
                                   .y_max = seen.y_max + dy};
    for (int y = 0; y < lens.height; ++y) {
      for (int x = 0; x < lens.width; ++x) {
        const Vec3& ray = rays[static_cast<std::size_t>(y * lens.width + x)];
        if (window.holds(ray.x, ray.y)) {
          widen(runs[static_cast<std::size_t>(y)], x, x + 1);
        }
      }
    }
  }
  return runs;
}

std::vector<Run> grown(const std::vector<Run>& runs, int width, int reach) {
  const int height = static_cast<int>(runs.size());
  std::vector<Run> out(runs.size());
  for (int y = 0; y < height; ++y) {
    for (int from = std::max(y - reach, 0); from <= std::min(y + reach, height - 1); ++from) {
      const Run& run = runs[static_cast<std::size_t>(from)];
      if (run.end > run.begin) {
        widen(out[static_cast<std::size_t>(y)], std::max(run.begin - reach, 0),
              std::min(run.end + reach, width));
      }
    }
  }
  return out;
}

std::vector<Run> whole_picture(const dsp::Pinhole& lens) {
  return std::vector<Run>(static_cast<std::size_t>(lens.height), Run{0, lens.width});
}

}  // namespace stof::hal::emu
