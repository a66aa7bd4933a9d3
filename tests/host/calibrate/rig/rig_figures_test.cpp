// What calibrations of emulated rigs come to, against the truth of the emulator: lines that begin
// with `figure: `, which scripts/calib_bench collects.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "dataset/dataset.h"
#include "dsp/base/parse_number.h"
#include "dsp/calib/pmd/ray_table.h"
#include "dsp/calib/stereo/rectification.h"
#include "dsp/stereo/match_params.h"
#include "host/calibrate/rig/extrinsics/pmd_board_views.h"
#include "host/calibrate/rig/extrinsics/wall_pairs.h"
#include "host/calibrate/rig/planes/plane_judgement.h"
#include "host/calibrate/rig/target/target_calibration.h"
#include "host/calibrate/rig/target/target_sheet.h"
#include "host/evaluate/fusion/owning_depth_maker.h"
#include "host/text/printed.h"
#include "tests/dataset/scratch.h"
#include "tests/host/calibrate/rig/board_views.h"
#include "tests/host/calibrate/rig/emulated_rig.h"

namespace stof::host {
namespace {

using test::emulate;
using test::EmulatorFlags;
using test::pair_of;

constexpr double kDegree = std::numbers::pi / 180;

// One line of the table, and the promise.
void figure(const std::string& what, double value, double most, const char* unit) {
  std::printf("figure: %-52s %8.4f %s (<= %g)\n", what.c_str(), value, unit, most);
  EXPECT_LE(value, most) << what;
}

class RigFigures : public ::stof::test::Scratch {
 protected:
  std::filesystem::path set() const { return folder() / "set"; }
};

EmulatorFlags operator+(EmulatorFlags flags, const EmulatorFlags& more) {
  flags.insert(flags.end(), more.begin(), more.end());
  return flags;
}

TEST_F(RigFigures, WallsBeforeTheChaptersRig) {
  const EmulatorFlags flags{
      "--scene", "plane", "--rig",   "chapter",
      "--pmd",   "none",  "--poses", "distances:1.6,1.9,2.2,2.5,2.8,3.1,3.4,3.7,4"};
  ASSERT_TRUE(emulate(set(), flags));
  const dataset::CalibrationTruth truth = test::truth_of(flags);
  ASSERT_TRUE(truth.converging);
  const dsp::Converging& c = *truth.converging;
  const std::array<double, 3>& t = truth.left_to_right.translation_m;
  const PlaneUnknowns rig{std::hypot(t[0], t[1], t[2]), c.alpha_rad, c.beta_rad, c.f1_m, c.f2_m};

  const dataset::Loaded<std::vector<Plane>> planes =
      read_planes(set(), {.min_disparity = -20, .disparities = 160, .threads = 2});
  ASSERT_TRUE(planes) << planes.error().message;
  PlaneCalibrationOptions options;
  options.sensor = {
      .pixel_m = c.pixel_m, .cx_left = c.cx_left, .cx_right = c.cx_right, .cy = truth.left.cy};
  const dataset::Loaded<PlaneCalibration> found = calibrate_planes(*planes, options);
  ASSERT_TRUE(found) << found.error().message;
  for (const WallJudgement& wall : found->walls) {
    std::printf("figure: wall at %.1f m: %.2f mm about its plane, bias %+.2f mm%s\n", wall.z_m,
                wall.spread_m * 1000, wall.bias_m * 1000, wall.fitted ? "" : ", held out");
  }
  figure("planes: pooled standard deviation, fitted", pooled_spread_m(found->walls, true) * 1000,
         7.7, "mm");
  figure("planes: pooled standard deviation, held out", pooled_spread_m(found->walls, false) * 1000,
         7.7, "mm");
  figure("planes: b F cos^2(alpha) off by",
         std::abs(triangulation_constant(found->fit.x) / triangulation_constant(rig) - 1) * 100,
         0.5, "percent");
  figure("planes: genes alone to refined residual", found->genes.rms_m / found->refined_rms_m, 3,
         "times");
  figure("planes: genes take", found->genes.seconds, 60, "s");
}

// What calibrate_target() makes of a set; nothing where it fails.
std::optional<TargetCalibration> of_target(const std::filesystem::path& set, const Board& board) {
  const TargetOptions options{.board = board};
  dataset::Loaded<TargetViews> views = find_views(set, options);
  EXPECT_TRUE(views) << (views ? "" : views.error().message);
  if (!views) {
    return std::nullopt;
  }
  for (const RefusedView& view : views->refused) {
    std::printf("left out: %s: %s\n", view.name.c_str(), view.why.c_str());
  }
  dataset::Loaded<TargetCalibration> found = calibrate_target(std::move(*views), options);
  EXPECT_TRUE(found) << (found ? "" : found.error().message);
  return found ? std::optional(std::move(*found)) : std::nullopt;
}

struct TargetErrors {
  double focal = 0;   // percent, the largest of four
  double turn = 0;    // degrees
  double row_px = 0;  // rms over the whole picture
};

TargetErrors errors_of(const dsp::RawPair& rig, const dsp::RawPair& truth) {
  TargetErrors errors;
  for (const double ratio : {rig.left.fx / truth.left.fx, rig.left.fy / truth.left.fy,
                             rig.right.fx / truth.right.fx, rig.right.fy / truth.right.fy}) {
    errors.focal = std::max(errors.focal, std::abs(ratio - 1) * 100);
  }
  errors.turn = test::angle_between(rig.left_to_right, truth.left_to_right) / kDegree;
  errors.row_px = test::row_rms_of_truth(truth, rig);
  return errors;
}

// The rig, off by 2 degrees and 3 rows, whose board is a chessboard of A2. 20 views are fitted to
// and 5 judge.
EmulatorFlags board_set(int seed) {
  return {"--scene",    "board:chess,12x9,0.04",
          "--misbuilt", std::to_string(seed),
          "--poses",    "wave:25," + std::to_string(seed),
          "--pmd",      "none",
          "--blur",     "0.6"};
}
constexpr Board kBoard{.columns = 12, .rows = 9, .square_m = 0.04};

TEST_F(RigFigures, ViewsOfABoardAndThePairThatIsRectifiedByThem) {
  constexpr int kSeeds = 3;
  TargetErrors worst;
  double turned = 0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    ASSERT_TRUE(emulate(set(), board_set(seed)));
    const dsp::RawPair truth = pair_of(test::truth_of(board_set(seed)));
    const std::optional<TargetCalibration> found = of_target(set(), kBoard);
    ASSERT_TRUE(found && found->judgement);
    const TargetErrors errors = errors_of(found->fit.rig, truth);
    std::printf(
        "figure: target, rig %d: %zu views, corners %.3f px, focal %.3f percent, turn %.4f "
        "degrees, rows %.3f px; held out: reprojection %.3f px, rows %.3f px\n",
        seed, found->fitted.size(), found->fit.corner_sigma_px, errors.focal, errors.turn,
        errors.row_px, found->judgement->reprojection_px, found->judgement->row_px);
    worst.focal = std::max(worst.focal, errors.focal);
    worst.row_px = std::max(worst.row_px, errors.row_px);
    turned += errors.turn * errors.turn / kSeeds;
    std::filesystem::remove_all(set());
  }
  figure("target: focal lengths off by, at most", worst.focal, 0.3, "percent");
  figure("target: rotation off by, rms of 3 rigs", std::sqrt(turned), 0.03, "degrees");
  figure("target: rows of truth points, worst rig", worst.row_px, 0.1, "px");
}

// Boards with markers, as `stof calib target` prints them.
class RigFiguresOfMarkers : public RigFigures {
 protected:
  void calibrate(const char* name) const {
    const dataset::Loaded<Board> board = board_named(name);
    ASSERT_TRUE(board);
    const std::optional<BoardPicture> sheet = picture_of(*board);
    ASSERT_TRUE(sheet);
    const std::filesystem::path file = folder() / "board.pgm";
    ASSERT_TRUE(dataset::write_pgm8(file, sheet->picture));
    EmulatorFlags flags = board_set(5);
    flags[1] = "board:print," + file.string() + "," + printed("%.9g", sheet->pixel_mm);
    ASSERT_TRUE(emulate(set(), flags));
    const dsp::RawPair truth = pair_of(test::truth_of(flags));
    const std::optional<TargetCalibration> found = of_target(set(), *board);
    ASSERT_TRUE(found && found->judgement);
    const TargetErrors errors = errors_of(found->fit.rig, truth);
    std::printf("figure: %s: %zu views, corners %.3f px, held out: reprojection %.3f px\n", name,
                found->fitted.size(), found->fit.corner_sigma_px,
                found->judgement->reprojection_px);
    figure(std::string(name) + ": focal lengths off by", errors.focal, 0.3, "percent");
    figure(std::string(name) + ": rotation off by", errors.turn, 0.03, "degrees");
    figure(std::string(name) + ": rows of truth points", errors.row_px, 0.1, "px");
  }
};
TEST_F(RigFiguresOfMarkers, ViewsOfACharucoBoard) { calibrate("charuco:12x9:0.04"); }
TEST_F(RigFiguresOfMarkers, ViewsOfAnAprilGrid) { calibrate("aprilgrid:6x5:0.07:0.3"); }

// The disparity that pictures rectified by `rig` really show, from what those of a perfect pair do.
class TrueDisparity {
 public:
  TrueDisparity(const dsp::RawPair& truth, const dsp::RawPair& rig)
      : truth_(truth),
        rig_(rig),
        perfect_(dsp::rectify(truth)),
        found_(dsp::rectify(rig)),
        left_(rig.left, found_.left_turn, found_.left) {}

  // NaN where nothing is known. `disparity` and `visible` of the perfect pair.
  double at(int u, int v, const dataset::StereoScene& perfect) const {
    const dsp::SourceMap::Place raw = left_.at(u, v);
    const Vector3 ray = ray_of(truth_.left, raw.u, raw.v);
    const Vector3 turned = matrix_of(perfect_.left_turn) * ray;
    const dsp::Pinhole& lens = perfect_.left;
    const int x = static_cast<int>(std::lround(lens.fx * turned.x() / turned.z() + lens.cx));
    const int y = static_cast<int>(std::lround(lens.fy * turned.y() / turned.z() + lens.cy));
    if (!raw.inside || x < 0 || y < 0 || x >= lens.width || y >= lens.height ||
        perfect.visible->view().at(x, y) == 0) {
      return std::nan("");
    }
    const double gap =
        static_cast<double>(perfect.truth->view().at(x, y)) + perfect_.right.cx - lens.cx;
    const Vector3 point = ray * (lens.fx * perfect_.baseline_m / gap / turned.z());
    const PoseUnknowns pose = pose_of(truth_.left_to_right);
    const Vector3 other = rotation_of(pose) * point + translation_of(pose);
    std::array<double, 2> pixel{};
    const LensUnknowns right = unknowns_of(truth_.right);
    if (!project(right.data(), {other.x(), other.y(), other.z()}, pixel)) {
      return std::nan("");
    }
    const Vector3 seen = matrix_of(found_.right_turn) * ray_of(rig_.right, pixel[0], pixel[1]);
    return u - (found_.right.fx * seen.x() / seen.z() + found_.right.cx);
  }

 private:
  static Matrix3 matrix_of(const std::array<double, 9>& elements) {
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(elements.data());
  }
  static Vector3 ray_of(const dsp::Pinhole& lens, double u, double v) {
    const std::array<double, 3> ray = dsp::unit_ray(lens, u, v);
    return {ray[0], ray[1], ray[2]};
  }

  dsp::RawPair truth_;
  dsp::RawPair rig_;
  dsp::Rectification perfect_;
  dsp::Rectification found_;
  dsp::SourceMap left_;
};

// Share of pixels with a known disparity that are off by more than 1 px, or have none; percent.
template <typename Truth>
double bad_pixels(const dsp::StereoRig& stereo, const dataset::StereoScene& pictures,
                  const Truth& truth) {
  dsp::Calibration rig;
  rig.stereo = stereo;
  dsp::MatchParams params = dsp::for_depth(*dsp::find_preset("quality"));
  params.disparities = 96;
  dataset::Loaded<std::unique_ptr<OwningDepthMaker>> maker =
      OwningDepthMaker::make("bp", rig, pictures.left.width, pictures.left.height,
                             lab::as_the_appliance(params), {.threads = 2});
  EXPECT_TRUE(maker) << (maker ? "" : maker.error().message);
  (**maker)->match(pictures.left.view(), pictures.right.view());
  const dsp::ImageView<const dsp::Disparity> found = (**maker)->stereo().disparity;
  double known = 0;
  double bad = 0;
  for (int y = 0; y < found.height(); ++y) {
    for (int x = 0; x < found.width(); ++x) {
      const double d = truth(x, y);
      if (std::isfinite(d)) {
        const dsp::Disparity here = found.at(x, y);
        known += 1;
        bad += here.valid() && std::abs(static_cast<double>(here.pixels()) - d) <= 1 ? 0 : 1;
      }
    }
  }
  EXPECT_GT(known, 100000);
  return 100 * bad / known;
}

TEST_F(RigFigures, BadPixelsOfThePairThatIsRectified) {
  const EmulatorFlags built{"--misbuilt", "4,2,3", "--pmd", "none"};
  ASSERT_TRUE(emulate(set(), board_set(4)));
  const std::optional<TargetCalibration> found = of_target(set(), kBoard);
  ASSERT_TRUE(found);
  // The scene's rig has the board's lenses: both are the corridor's.
  const dsp::RawPair truth = pair_of(test::truth_of(built));
  ASSERT_EQ(truth.left.fx, test::truth_of(board_set(4)).left.fx);
  const std::filesystem::path scene = folder() / "scene";
  ASSERT_TRUE(emulate(scene, built));
  const dataset::Loaded<dataset::StereoScene> raw = dataset::read_stereo_scene(scene);
  const dataset::Loaded<dataset::StereoScene> perfect = dataset::read_stereo_scene(scene / "ideal");
  ASSERT_TRUE(raw && perfect && perfect->truth && perfect->visible && perfect->rig);
  dsp::StereoRig calibrated;
  calibrated.raw = found->fit.rig;
  ASSERT_STREQ(dsp::complete(calibrated), "");
  const TrueDisparity shown(truth, found->fit.rig);
  const double rectified =
      bad_pixels(calibrated, *raw, [&](int x, int y) { return shown.at(x, y, *perfect); });
  const double ideal = bad_pixels(*perfect->rig, *perfect, [&](int x, int y) {
    return perfect->visible->view().at(x, y) == 0
               ? std::nan("")
               : static_cast<double>(perfect->truth->view().at(x, y));
  });
  std::printf("figure: bad pixels: rectified %.2f percent, perfect pair %.2f percent\n", rectified,
              ideal);
  figure("bad pixels more than the perfect pair's", rectified - ideal, 1, "points");
}

// The rig as it is known before its PMD camera is placed.
dsp::Calibration without_place(const dataset::CalibrationTruth& truth,
                               const dataset::PmdRecording& recording) {
  dsp::Calibration rig;
  rig.stereo.raw = pair_of(truth);
  EXPECT_STREQ(dsp::complete(rig.stereo), "");
  rig.pmd = recording.calibration.pmd;
  return rig;
}

// A PMD camera that was placed, against the truth.
struct Place {
  Eigen::Matrix<double, 6, 1> off;  // rotation, radians; translation, m
  double squared = 0;               // normalised, of 6 degrees of freedom

  double degrees() const { return off.head<3>().norm() / kDegree; }
  double mm() const { return off.tail<3>().norm() * 1000; }
};

Place place_of(const ExtrinsicFit& fit, const dataset::CalibrationTruth& truth) {
  const Eigen::Matrix<double, 6, 1> off =
      difference(fit.pmd_to_stereo, pose_of(test::pmd_to_rectified(truth)));
  return {.off = off, .squared = off.dot(fit.covariance.ldlt().solve(off))};
}

// Walls at several tilts in a folder of their own, read as a user's are; nullopt where they place
// nothing.
std::optional<Place> place_by_walls(const std::filesystem::path& set, const EmulatorFlags& rig) {
  const EmulatorFlags flags = EmulatorFlags{"--scene", "plane"} + rig;
  EXPECT_TRUE(emulate(set, flags + EmulatorFlags{"--frames", "16"}));
  const dataset::CalibrationTruth truth = test::truth_of(flags);
  const dataset::Loaded<dataset::PmdRecording> first = dataset::read_pmd(set / "pose_000" / "pmd");
  EXPECT_TRUE(first) << first.error().message;
  if (!first) {
    return std::nullopt;
  }
  const dataset::Loaded<std::vector<BothLooks>> looks =
      read_looks(set, without_place(truth, *first), {.threads = 2});
  EXPECT_TRUE(looks) << looks.error().message;
  if (!looks) {
    return std::nullopt;
  }
  const FoundWalls found = walls_of(*looks);
  for (const std::string& line : found.refused) {
    std::printf("left out: %s\n", line.c_str());
  }
  const std::optional<ExtrinsicFit> fit = fit_extrinsics(found.walls, {});
  std::filesystem::remove_all(set);
  return fit ? std::optional(place_of(*fit, truth)) : std::nullopt;
}

TEST_F(RigFigures, ThePmdCameraByWalls) {
  for (const auto& [size, degrees, mm] :
       {std::tuple("64x16", 0.3, 15.0), std::tuple("176x144", 0.1, 5.0)}) {
    const std::optional<Place> place =
        place_by_walls(set(), {"--misbuilt", "3", "--poses", "tilts:8,3", "--pmd", size});
    ASSERT_TRUE(place) << size;
    const std::string what = std::string("PMD by walls, ") + size;
    std::printf("figure: %s: normalised squared error %.1f (6 degrees of freedom)\n", what.c_str(),
                place->squared);
    figure(what + ": rotation off by", place->degrees(), degrees, "degrees");
    figure(what + ": translation off by", place->mm(), mm, "mm");
  }
}

// A board of so many corners, as the emulator and as the finder are told of it.
struct PmdBoard {
  Board board;
  const char* scene;
};
constexpr PmdBoard kLargeBoard{{.columns = 9, .rows = 6, .square_m = 0.07}, "board:chess,9x6,0.07"};

// Views of a board in a folder of their own, read as a user's are; nullopt where they place
// nothing.
std::optional<Place> place_by_board(const std::filesystem::path& set, const PmdBoard& board,
                                    const EmulatorFlags& flags) {
  EXPECT_TRUE(emulate(set, flags + EmulatorFlags{"--frames", "8"}));
  const dataset::CalibrationTruth truth = test::truth_of(flags);
  const dataset::Loaded<dataset::PmdRecording> first = dataset::read_pmd(set / "pose_000" / "pmd");
  EXPECT_TRUE(first) << first.error().message;
  if (!first) {
    return std::nullopt;
  }
  const dsp::Calibration rig = without_place(truth, *first);
  const dataset::Loaded<PmdBoardViews> found = read_board_views(set, rig, board.board);
  EXPECT_TRUE(found) << found.error().message;
  const std::optional<ExtrinsicFit> fit =
      found ? fit_extrinsics(board.board, found->views, fixed_pair(rig.stereo), rig.pmd.lens)
            : std::nullopt;
  std::filesystem::remove_all(set);
  if (!fit) {
    return std::nullopt;
  }
  return place_of(*fit, truth);
}

// How many rigs, and the first of them: 100 take half an hour on two cores, which is for
// scripts/calib_bench.
int asked_for(const char* variable, int otherwise) {
  const char* const text = std::getenv(variable);
  return dsp::parse_number_in<int>(text == nullptr ? "" : text, 1, 10000).value_or(otherwise);
}

// The worst of many rigs, and whether their covariances are those of the errors.
class PlacedRigs {
 public:
  explicit PlacedRigs(std::string what) : what_(std::move(what)) {}

  // place(number): of the rig of that number.
  void place_each(const std::function<std::optional<Place>(const std::string& number)>& place) {
    for (int seed = first_; seed < first_ + seeds_; ++seed) {
      const std::optional<Place> one = place(std::to_string(seed));
      ASSERT_TRUE(one) << "rig " << seed;
      mean_ += one->squared / seeds_;
      inside_ += one->squared <= kEllipsoid95 ? 1 : 0;
      degrees_ = std::max(degrees_, one->degrees());
      mm_ = std::max(mm_, one->mm());
    }
  }
  void judge(double most_degrees, double most_mm) const {
    std::printf(
        "figure: %s, %d rendered rigs from %d on: mean normalised squared error %.2f (of 6), "
        "%d inside the 95 percent ellipsoid\n",
        what_.c_str(), seeds_, first_, mean_, inside_);
    figure(what_ + ", worst of all rigs: rotation off by", degrees_, most_degrees, "degrees");
    figure(what_ + ", worst of all rigs: translation off by", mm_, most_mm, "mm");
    // Of 100 rigs the mean scatters by 0.35.
    EXPECT_NEAR(mean_, 6, 0.7 * std::max(1.0, std::sqrt(100.0 / seeds_)));
    EXPECT_GE(inside_, 0.9 * seeds_ - (seeds_ < 100 ? 1 : 0));
  }

 private:
  static constexpr double kEllipsoid95 = 12.592;  // chi^2, 6 degrees of freedom

  std::string what_;
  int seeds_ = asked_for("STOF_CALIB_SEEDS", 6);
  int first_ = asked_for("STOF_CALIB_FIRST", 1);
  double mean_ = 0;
  double degrees_ = 0;
  double mm_ = 0;
  int inside_ = 0;
};

TEST_F(RigFigures, PmdCamerasByWallsAndTheirCovarianceIsThatOfTheErrors) {
  for (const auto& [size, degrees, mm] :
       {std::tuple("64x16", 0.3, 15.0), std::tuple("176x144", 0.1, 5.0)}) {
    PlacedRigs rigs(std::string("PMD by walls, ") + size);
    ASSERT_NO_FATAL_FAILURE(rigs.place_each([&, size = size](const std::string& number) {
      return place_by_walls(set(),
                            {"--misbuilt", number, "--poses", "tilts:8," + number, "--pmd", size});
    }));
    rigs.judge(degrees, mm);
  }
}

TEST_F(RigFigures, PmdCamerasByABoardAndTheirCovarianceIsThatOfTheErrors) {
  PlacedRigs rigs("PMD by a board");
  ASSERT_NO_FATAL_FAILURE(rigs.place_each([&](const std::string& number) {
    return place_by_board(set(), kLargeBoard,
                          {"--scene", kLargeBoard.scene, "--misbuilt", number, "--poses",
                           "wave:12," + number, "--pmd", "176x144"});
  }));
  rigs.judge(0.1, 5);
}

}  // namespace
}  // namespace stof::host
