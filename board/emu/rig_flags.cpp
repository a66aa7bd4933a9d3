#include "board/emu/rig_flags.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "dsp/base/parse_number.h"
#include "dsp/base/random.h"
#include "dsp/calib/stereo/rectification.h"
#include "hal/emu/imagery/lens_rays.h"

namespace stof::board {
namespace {

namespace emu = hal::emu;

constexpr double kMostBlur = 5;  // px
constexpr double kMostTurn = 30;
constexpr double kMostRows = 50;

// Numbers between commas: as many as there are, at most out.size(); 0: one of them is none.
std::size_t numbers_of(std::string_view text, std::span<double> out) {
  std::size_t count = 0;
  for (std::size_t begin = 0; begin <= text.size(); ++count) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const auto number = dsp::parse_number<double>(text.substr(begin, end - begin));
    if (count == out.size() || !number || !std::isfinite(*number)) {
      return 0;
    }
    out[count] = *number;
    begin = end + 1;
  }
  return count;
}

std::optional<dsp::Pinhole> parse_lens(std::string_view text) {
  std::array<double, 9> n{};
  const std::size_t count = numbers_of(text, n);
  if (count != 4 && count != 6 && count != 8 && count != 9) {
    return std::nullopt;
  }
  return dsp::Pinhole{.fx = n[0],
                      .fy = n[1],
                      .cx = n[2],
                      .cy = n[3],
                      .k1 = n[4],
                      .k2 = n[5],
                      .k3 = n[8],
                      .p1 = n[6],
                      .p2 = n[7]};
}

std::optional<CameraPlace> parse_place(std::string_view text) {
  CameraPlace place{};
  return numbers_of(text, place) == place.size() ? std::optional(place) : std::nullopt;
}

std::optional<Misbuilt> parse_misbuilt(std::string_view text) {
  const std::size_t comma = text.find(',');
  const auto seed = dsp::parse_number<std::uint32_t>(text.substr(0, comma));
  if (!seed) {
    return std::nullopt;
  }
  Misbuilt out{.seed = *seed};
  if (comma == std::string_view::npos) {
    return out;
  }
  std::array<double, 2> n{};
  if (numbers_of(text.substr(comma + 1), n) != n.size() || n[0] < 0 || n[0] > kMostTurn ||
      std::abs(n[1]) > kMostRows) {
    return std::nullopt;
  }
  out.degrees = n[0];
  out.rows = n[1];
  return out;
}

// Stores what a flag's value is, or says what it takes.
template <typename T>
std::expected<bool, std::string> store(std::string_view flag, std::string_view value,
                                       const char* takes, const std::optional<T>& parsed,
                                       auto& to) {
  if (!parsed) {
    return refuse_value(flag, takes, value);
  }
  to = *parsed;
  return true;
}

constexpr const char* kLensTakes = "FX,FY,CX,CY[,K1,K2[,P1,P2[,K3]]]";
constexpr const char* kPlaceTakes = "YAW,PITCH,ROLL,X,Y,Z in degrees and metres";

emu::Pose pose_of(const CameraPlace& place) {
  emu::Pose out = emu::turned(emu::half_tangent(place[0]), emu::half_tangent(place[1]),
                              emu::half_tangent(place[2]));
  out.position = {place[3], place[4], place[5]};
  return out;
}

dsp::RigidTransform transform_of(const emu::Pose& pose) {
  return {.rotation = pose.rotation,
          .translation_m = {pose.position.x, pose.position.y, pose.position.z}};
}

// A lens of the same size with the numbers of another.
dsp::Pinhole with_size_of(const dsp::Pinhole& size, dsp::Pinhole lens) {
  lens.width = size.width;
  lens.height = size.height;
  return lens;
}

class Draw {
 public:
  explicit Draw(std::uint32_t seed) : random_(dsp::mix(seed) + 0x0FF) {}
  double within(double middle, double half) {
    return middle + half * (static_cast<double>(random_.next() >> 11U) * 0x1p-52 - 1);
  }

 private:
  dsp::SplitMix64 random_;
};

dsp::Pinhole misbuilt_lens(dsp::Pinhole lens, Draw& draw) {
  lens.fx *= draw.within(1, 0.015);
  lens.fy = lens.fx * draw.within(1, 0.002);
  lens.cx += draw.within(0, 0.0125 * lens.width);
  lens.cy += draw.within(0, 0.0125 * lens.height);
  lens.k1 = draw.within(-0.22, 0.06);
  lens.k2 = draw.within(0.08, 0.03);
  lens.k3 = draw.within(0, 0.01);
  lens.p1 = draw.within(0, 0.001);
  lens.p2 = draw.within(0, 0.001);
  return lens;
}

// A turn of so many degrees about any axis.
emu::Pose any_turn(double degrees, Draw& draw) {
  emu::Vec3 axis;
  double size = 0;
  while (size < 0.1 || size > 1) {
    axis = {draw.within(0, 1), draw.within(0, 1), draw.within(0, 1)};
    size = emu::length(axis);
  }
  // Cayley's map: (1 - S)^-1 (1 + S) of S = tan(angle / 2) times the axis.
  const emu::Vec3 s = (emu::half_tangent(degrees) / size) * axis;
  const double n = 1 / (1 + emu::dot(s, s));
  return {.rotation = {n * (1 + s.x * s.x - s.y * s.y - s.z * s.z), 2 * n * (s.x * s.y - s.z),
                       2 * n * (s.x * s.z + s.y), 2 * n * (s.x * s.y + s.z),
                       n * (1 - s.x * s.x + s.y * s.y - s.z * s.z), 2 * n * (s.y * s.z - s.x),
                       2 * n * (s.x * s.z - s.y), 2 * n * (s.y * s.z + s.x),
                       n * (1 - s.x * s.x - s.y * s.y + s.z * s.z)},
          .position = {}};
}

// The cameras as they are, in the axes of the left one.
struct Cameras {
  dsp::Pinhole left;
  dsp::Pinhole right;
  emu::Pose right_pose;
  dsp::Pinhole pmd;
  emu::Pose pmd_pose;
};

Cameras cameras_of(const emu::Rig& rig) {
  const emu::Eye left = emu::left_eye(rig);
  const emu::Eye right = emu::right_eye(rig);
  const std::array<double, 3>& t = rig.pmd_to_stereo.translation_m;
  const emu::Pose pmd{.rotation = rig.pmd_to_stereo.rotation, .position = {t[0], t[1], t[2]}};
  const emu::Pose to_left = emu::inverse(left.pose);
  return {.left = left.lens,
          .right = right.lens,
          .right_pose = to_left * right.pose,
          .pmd = rig.pmd_lens,
          .pmd_pose = to_left * pmd};
}

void misbuild(const Misbuilt& how, Cameras& cameras) {
  Draw draw(how.seed);
  cameras.left = misbuilt_lens(cameras.left, draw);
  cameras.right = misbuilt_lens(cameras.right, draw);
  cameras.right.cy = cameras.left.cy + how.rows;
  const emu::Vec3 at = cameras.right_pose.position;
  cameras.right_pose = any_turn(how.degrees, draw) * cameras.right_pose;
  cameras.right_pose.position =
      at + emu::Vec3{draw.within(0, 0.002), draw.within(0, 0.002), draw.within(0, 0.002)};
  constexpr double kPmdDegrees = 1;
  const emu::Vec3 pmd_at = cameras.pmd_pose.position;
  cameras.pmd_pose = any_turn(kPmdDegrees, draw) * cameras.pmd_pose;
  cameras.pmd_pose.position =
      pmd_at + emu::Vec3{draw.within(0, 0.005), draw.within(0, 0.005), draw.within(0, 0.005)};
}

}  // namespace

std::unexpected<std::string> refuse_value(std::string_view flag, const char* what,
                                          std::string_view value) {
  std::string line(flag);
  line += " takes ";
  line += what;
  line += ", not \"";
  line += value;
  line += "\"; try --help";
  return std::unexpected(std::move(line));
}

std::expected<bool, std::string> take_rig_flag(std::string_view flag, std::string_view value,
                                               RigOptions& options) {
  if (flag == "--rig") {
    const bool known = value == "corridor" || value == "hall" || value == "chapter";
    return store(flag, value, "corridor, hall or chapter",
                 known ? std::optional(std::string(value)) : std::nullopt, options.name);
  }
  if (flag == "--misbuilt") {
    return store(flag, value, "SEED[,DEGREES,ROWS], up to 30 degrees and 50 rows",
                 parse_misbuilt(value), options.misbuilt);
  }
  if (flag == "--left-lens") {
    return store(flag, value, kLensTakes, parse_lens(value), options.left_lens);
  }
  if (flag == "--right-lens") {
    return store(flag, value, kLensTakes, parse_lens(value), options.right_lens);
  }
  if (flag == "--pmd-lens") {
    return store(flag, value, kLensTakes, parse_lens(value), options.pmd_lens);
  }
  if (flag == "--right-place") {
    return store(flag, value, kPlaceTakes, parse_place(value), options.right_place);
  }
  if (flag == "--pmd-place") {
    return store(flag, value, kPlaceTakes, parse_place(value), options.pmd_place);
  }
  if (flag == "--blur") {
    return store(flag, value, "pixels, 0 to 5", dsp::parse_number_in<double>(value, 0, kMostBlur),
                 options.lenses.blur_px);
  }
  if (flag == "--pmd-blur") {
    return store(flag, value, "pixels, 0 to 5", dsp::parse_number_in<double>(value, 0, kMostBlur),
                 options.pmd_blur_px);
  }
  if (flag == "--vignetting") {
    return store(flag, value, "a share, 0 to 0.9", dsp::parse_number_in<double>(value, 0, 0.9),
                 options.lenses.vignetting);
  }
  if (flag == "--pmd-light") {
    return store(flag, value, "a share of the PMD camera's light, 0.001 to 100",
                 dsp::parse_number_in<double>(value, 0.001, 100), options.pmd_light);
  }
  if (flag == "--publish") {
    const bool known = value == "truth" || value == "drawing";
    return store(flag, value, "truth or drawing",
                 known ? std::optional(value == "drawing") : std::nullopt,
                 options.publishes_drawing);
  }
  return false;
}

std::string_view rig_usage() noexcept {
  return "  --rig NAME           corridor, hall, or chapter (8.5 mm, 0.20 m, axes that meet at 4 "
         "m), in\n"
         "                       place of the scene's own\n"
         "  --misbuilt SEED[,DEGREES,ROWS]\n"
         "                       lenses that bend, a right camera turned and lowered (default 2 "
         "degrees,\n"
         "                       3 rows), a PMD camera turned by a degree: raw pictures, which "
         "the\n"
         "                       calibration rectifies\n"
         "  --left-lens FX,FY,CX,CY[,K1,K2[,P1,P2[,K3]]], --right-lens, --pmd-lens\n"
         "                       as OpenCV counts them\n"
         "  --right-place YAW,PITCH,ROLL,X,Y,Z, --pmd-place\n"
         "                       degrees and metres, in the axes of the left camera as it is\n"
         "  --blur PX            Gaussian blur of the pair's lenses (standard deviation); "
         "--pmd-blur PX\n"
         "  --vignetting SHARE   of light that the corners lack\n"
         "  --pmd-light SHARE    of the PMD camera's light (default 1; before boards 0.08)\n"
         "  --publish drawing    the calibration is what the rig was meant to be; else the truth\n";
}

emu::Rig named_rig(const RigOptions& options, emu::Rig own) {
  emu::Rig rig = std::move(own);
  if (options.name.empty()) {
    return rig;
  }
  const emu::Pose pose = rig.left_camera_pose;
  rig = options.name == "hall" ? emu::hall_rig() : emu::corridor_rig();
  if (options.name == "chapter") {
    rig = emu::chapter_rig();
  }
  rig.left_camera_pose = pose;
  return rig;
}

std::expected<emu::Rig, std::string> changed_rig(emu::Rig rig, const RigOptions& options) {
  if (options.publishes_drawing) {
    rig.published = emu::PublishedGeometry{
        .stereo = rig.stereo, .pmd_lens = rig.pmd_lens, .pmd_to_stereo = rig.pmd_to_stereo};
  }
  Cameras cameras = cameras_of(rig);
  if (options.misbuilt) {
    misbuild(*options.misbuilt, cameras);
  }
  if (options.left_lens) {
    cameras.left = with_size_of(cameras.left, *options.left_lens);
  }
  if (options.right_lens) {
    cameras.right = with_size_of(cameras.right, *options.right_lens);
  }
  if (options.right_place) {
    cameras.right_pose = pose_of(*options.right_place);
  }
  if (options.pmd_lens && rig.pmd_lens.width > 0) {
    cameras.pmd = with_size_of(cameras.pmd, *options.pmd_lens);
  }
  if (options.pmd_place) {
    cameras.pmd_pose = pose_of(*options.pmd_place);
  }
  if (options.changes_pair()) {
    rig.stereo.converging.reset();
    rig.stereo.raw = dsp::RawPair{.left = cameras.left,
                                  .right = cameras.right,
                                  .left_to_right = transform_of(emu::inverse(cameras.right_pose))};
    if (const char* const why = dsp::complete(rig.stereo); *why != '\0') {
      return std::unexpected(std::string("this rig cannot be: ") + why);
    }
    for (const dsp::Pinhole& lens : {cameras.left, cameras.right}) {
      if (!emu::shows_each_place_once(lens)) {
        return std::unexpected("this rig cannot be: a lens of the pair folds within its picture");
      }
    }
  }
  rig.pmd_lens = cameras.pmd;
  if (rig.pmd_lens.width > 0) {
    if (options.pmd_lens && !emu::shows_each_place_once(rig.pmd_lens)) {
      return std::unexpected("this rig cannot be: the PMD camera's lens folds within its picture");
    }
    if (options.changes_pair() || options.pmd_place) {
      rig.pmd_to_stereo = transform_of(emu::left_eye(rig).pose * cameras.pmd_pose);
    }
  }
  rig.lenses = options.lenses;
  rig.pmd.blur_px = options.pmd_blur_px;
  if (options.rectified) {
    rig.stereo.raw.reset();
    rig.published.reset();
  }
  return rig;
}

dataset::CalibrationTruth truth_of(const emu::Rig& rig) {
  const Cameras cameras = cameras_of(rig);
  const emu::Pose left = emu::left_eye(rig).pose;
  dataset::CalibrationTruth truth{.left = cameras.left,
                                  .right = cameras.right,
                                  .left_to_right = transform_of(emu::inverse(cameras.right_pose)),
                                  .left_to_rig = left.rotation,
                                  .converging = rig.stereo.converging,
                                  .blur_px = rig.lenses.blur_px,
                                  .vignetting = rig.lenses.vignetting,
                                  .pmd_blur_px = rig.pmd.blur_px};
  if (rig.pmd_lens.width > 0) {
    truth.pmd = rig.pmd_lens;
    truth.pmd_to_left = transform_of(emu::inverse(left) * emu::true_pmd_pose(rig));
  }
  return truth;
}

}  // namespace stof::board
