#include "board/emu/scenes.h"

#include <algorithm>
#include <cmath>
#include <ranges>
#include <utility>
#include <vector>

#include "dsp/base/check.h"
#include "dsp/base/parse_number.h"
#include "hal/emu/imagery/grey.h"
#include "hal/emu/imagery/moving_scene.h"
#include "hal/emu/imagery/rendered_scene.h"
#include "hal/emu/scenes/drive.h"
#include "hal/emu/scenes/floor.h"
#include "hal/emu/scenes/room.h"
#include "hal/emu/scenes/scene.h"
#include "hal/emu/scenes/targets.h"

namespace stof::board {
namespace {

namespace emu = hal::emu;

constexpr std::string_view kRoom = "room:";
constexpr std::string_view kFloor = "floor:";
constexpr std::string_view kDrive = "drive:";
constexpr int kSmallest = 16;  // pixels a side
constexpr int kLargest = 2048;
constexpr double kMaxTurn = 10;      // degrees
constexpr double kMaxOffset = 1000;  // mm

std::optional<emu::Size> parse_size(std::string_view text) {
  const std::size_t times = text.find('x');
  if (times == std::string_view::npos) {
    return std::nullopt;
  }
  const auto width = dsp::parse_number_in<int>(text.substr(0, times), kSmallest, kLargest);
  const auto height = dsp::parse_number_in<int>(text.substr(times + 1), kSmallest, kLargest);
  return width && height ? std::optional(emu::Size{*width, *height}) : std::nullopt;
}

std::optional<std::uint32_t> room_seed(std::string_view name) {
  return name.starts_with(kRoom) ? dsp::parse_number<std::uint32_t>(name.substr(kRoom.size()))
                                 : std::nullopt;
}

// floor, or floor:HEIGHT_CM,TILT_DEGREES with or without ,SEED.
std::optional<emu::FloorView> floor_view(std::string_view name) {
  emu::FloorView view;
  if (name == "floor") {
    return view;
  }
  if (!name.starts_with(kFloor)) {
    return std::nullopt;
  }
  std::vector<std::string_view> words;
  for (const auto word : std::views::split(name.substr(kFloor.size()), ',')) {
    words.emplace_back(word.begin(), word.end());
  }
  if (words.size() != 2 && words.size() != 3) {
    return std::nullopt;
  }
  const auto height_cm = dsp::parse_number_in<double>(words[0], 100 * emu::kMinFloorHeightM,
                                                      100 * emu::kMaxFloorHeightM);
  const auto tilt = dsp::parse_number_in<double>(words[1], 0, emu::kMaxFloorTilt);
  const auto seed =
      words.size() == 3 ? dsp::parse_number<std::uint32_t>(words[2]) : std::optional(view.seed);
  if (!height_cm || !tilt || !seed) {
    return std::nullopt;
  }
  return emu::FloorView{.height_m = *height_cm / 100, .tilt_degrees = *tilt, .seed = *seed};
}

// drive:SCENE,SPEED.
struct DriveThrough {
  std::string scene;  // one that stands still
  double speed = 0;   // metres a second
};

std::optional<DriveThrough> drive_through(std::string_view name) {
  const std::size_t comma = name.rfind(',');
  if (!name.starts_with(kDrive) || comma == std::string_view::npos) {
    return std::nullopt;
  }
  const std::string_view scene = name.substr(kDrive.size(), comma - kDrive.size());
  const auto speed = dsp::parse_number_in<double>(name.substr(comma + 1), 0, emu::kMaxDriveSpeed);
  if (!speed || !(scene == "corridor" || scene == "hall" || room_seed(scene))) {
    return std::nullopt;
  }
  return DriveThrough{.scene = std::string(scene), .speed = *speed};
}

bool is_scene(std::string_view name) {
  return name == "corridor" || name == "walking" || name == "leaving" || name == "hall" ||
         room_seed(name) || floor_view(name) || drive_through(name) || emu::parse_bars(name) ||
         emu::parse_stripes(name) || emu::is_board(name);
}

// AXIS:DEGREES, such as pitch:0.1.
bool parse_turn(std::string_view text, emu::Misplacement& out) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) {
    return false;
  }
  const std::string_view axis = text.substr(0, colon);
  const auto degrees = dsp::parse_number_in<double>(text.substr(colon + 1), -kMaxTurn, kMaxTurn);
  if (!degrees) {
    return false;
  }
  if (axis == "pitch") {
    out.pitch_degrees = *degrees;
  } else if (axis == "yaw") {
    out.yaw_degrees = *degrees;
  } else if (axis == "roll") {
    out.roll_degrees = *degrees;
  } else {
    return false;
  }
  return true;
}

std::expected<emu::Rig, std::string> try_changed(emu::Rig own, const SceneOptions& options) {
  emu::Rig rig = named_rig(options.rig, std::move(own));
  if (options.size) {
    emu::resize_stereo(rig, options.size->width, options.size->height);
  }
  if (options.pmd == emu::Size{}) {
    rig.pmd_lens = {};
  } else if (options.pmd) {
    emu::resize_pmd(rig, options.pmd->width, options.pmd->height);
  }
  if (options.seed) {
    rig.seed = *options.seed;
  }
  rig.misplacement = options.misplacement;
  const double light = options.rig.pmd_light.value_or(board_light(options.name));
  rig.pmd.signal_e *= light;
  rig.pmd.ambient_e *= light;
  if (emu::is_board(options.name)) {
    constexpr int kRaysOfBoards = 8;  // edges in amplitude are measured
    rig.pmd.rays_per_side = kRaysOfBoards;
    rig.pmd.scattered_rays = true;
  }
  return changed_rig(std::move(rig), options.rig);
}

emu::Rig changed(emu::Rig own, const SceneOptions& options) {
  std::expected<emu::Rig, std::string> rig = try_changed(std::move(own), options);
  STOF_CHECK(rig.has_value());
  return *std::move(rig);
}

// The rig that a scene has been made for.
emu::Rig own_rig(std::string_view name) {
  if (const std::optional<emu::FloorView> view = floor_view(name)) {
    return emu::floor_scene(*view).rig;
  }
  if (const std::optional<DriveThrough> drive = drive_through(name)) {
    return own_rig(drive->scene);
  }
  if (const std::optional<std::uint32_t> seed = room_seed(name)) {
    return emu::random_room(*seed).rig;
  }
  if (name == "hall") {
    return emu::hall_rig();
  }
  if (emu::is_board(name)) {
    return board_rig();
  }
  return emu::parse_bars(name) || emu::parse_stripes(name) ? emu::target_rig()
                                                           : emu::corridor_rig();
}

// What stands still, and who looks at it.
struct StillScene {
  emu::Scene scene;
  emu::Rig rig;
};

StillScene still_scene(std::string_view name, const SceneOptions& options) {
  if (name == "hall") {
    return {emu::hall(), changed(emu::hall_rig(), options)};
  }
  if (const std::optional<std::uint32_t> seed = room_seed(name)) {
    const emu::Room room = emu::random_room(*seed);
    return {room.scene, changed(room.rig, options)};
  }
  const std::optional<emu::Bars> bars = emu::parse_bars(name);
  const std::optional<emu::Stripes> stripes = emu::parse_stripes(name);
  if (bars || stripes) {
    const emu::Rig rig = changed(emu::target_rig(), options);
    return {bars ? emu::bars_scene(*bars, rig.stereo.left)
                 : emu::stripes_scene(*stripes, rig.stereo.left),
            rig};
  }
  return {emu::corridor(), changed(emu::corridor_rig(), options)};
}

SceneWorld floor_world(const emu::FloorView& view, const SceneOptions& options) {
  const emu::FloorScene floor = emu::floor_scene(view);
  const emu::Rig rig = changed(floor.rig, options);
  SceneWorld world{.imagery = std::make_unique<emu::RenderedScene>(floor.scene, rig)};
  const dataset::Image<int> objects =
      emu::render_objects({floor.scene, rig.left_camera_pose}, emu::LensRays(rig.stereo.left));
  dataset::FloorTruth truth{.height_m = view.height_m,
                            .tilt_degrees = view.tilt_degrees,
                            .surface = {objects.width, objects.height}};
  std::ranges::transform(objects.pixels, truth.surface.pixels.begin(), [&](int object) {
    return object < 0 ? dataset::Surface::kOther : floor.surfaces[static_cast<std::size_t>(object)];
  });
  world.floor = std::move(truth);
  return world;
}

}  // namespace

std::expected<bool, std::string> take_scene_flag(std::string_view flag, std::string_view value,
                                                 SceneOptions& options) {
  if (flag == "--scene") {
    if (!is_scene(value)) {
      std::string line = "there is no scene \"";
      line += value;
      line +=
          "\"; the scenes are corridor, walking, leaving, hall, room:SEED, floor, "
          "floor:HEIGHT_CM,TILT_DEGREES[,SEED] (20 to 120 cm, 0 to 30 degrees), "
          "bars:WIDTH_PX,upright, bars:WIDTH_PX,level (0.5 to 100 px), "
          "stripes:PERIOD_PX[,PERCENT] (2 to 200 px, 0 to 100 percent), "
          "board:chess,COLUMNSxROWS,SQUARE_M, board:print,FILE.pgm,PIXEL_MM, plane and "
          "drive:SCENE,SPEED (corridor, hall or room:SEED, 0 to 1.5 metres a second)";
      return std::unexpected(std::move(line));
    }
    options.name = value;
  } else if (flag == "--size") {
    options.size = parse_size(value);
    if (!options.size) {
      return refuse_value(flag, "WxH, such as 640x480, 16 to 2048 a side", value);
    }
  } else if (flag == "--pmd") {
    options.pmd = value == "none" ? emu::Size{} : parse_size(value);
    if (!options.pmd) {
      return refuse_value(flag, "WxH, such as 176x144, 16 to 2048 a side, or none", value);
    }
  } else if (flag == "--seed") {
    options.seed = dsp::parse_number<std::uint32_t>(value);
    if (!options.seed) {
      return refuse_value(flag, "a whole number from 0 to 4294967295", value);
    }
  } else if (flag == "--turn") {
    if (!parse_turn(value, options.misplacement)) {
      return refuse_value(flag, "pitch:, yaw: or roll:DEGREES, up to 10, such as pitch:0.1", value);
    }
  } else if (flag == "--range-offset") {
    const auto offset = dsp::parse_number_in<double>(value, -kMaxOffset, kMaxOffset);
    if (!offset) {
      return refuse_value(flag, "millimetres, up to 1000", value);
    }
    options.misplacement.range_offset_m = *offset / 1000;
  } else {
    std::expected<bool, std::string> taken = take_rig_flag(flag, value, options.rig);
    return taken && !*taken ? take_board_flag(flag, value, options.board) : taken;
  }
  return true;
}

std::string_view scene_usage() noexcept {
  static constexpr std::string_view kScenes =
      "  --scene NAME         corridor (default), walking (somebody walks in it), hall (up to "
      "13.6 m,\n"
      "                       beyond the PMD camera's range), room:SEED (random), floor "
      "or\n"
      "                       floor:HEIGHT_CM,TILT_DEGREES[,SEED] (20 to 120 cm above a floor, "
      "0 to\n"
      "                       30 degrees downwards; default 60,15), leaving (a box is taken "
      "away, "
      "a\n"
      "                       door opens), drive:SCENE,SPEED (the rig drives through corridor, "
      "hall or\n"
      "                       room:SEED, to and fro, at up to 1.5 m/s), bars:WIDTH_PX,upright, "
      "or\n"
      "                       level (thin bars before a wall), stripes:PERIOD_PX[,PERCENT] (a "
      "wall of\n"
      "                       stripes, and their contrast), board:chess,COLUMNSxROWS,SQUARE_M "
      "(inner\n"
      "                       corners), board:print,FILE.pgm,PIXEL_MM (any pattern), plane (a "
      "textured\n"
      "                       wall): what calibrates a rig\n"
      "  --size WxH           of the stereo pictures (default 640x480)\n"
      "  --pmd WxH            of the PMD camera's pictures (default 176x144), or none\n"
      "  --seed N             of the noise\n"
      "  --turn AXIS:DEGREES  the PMD camera is turned from where its calibration says: "
      "pitch:, yaw:,\n"
      "                       roll: about x, y, z of the left camera; positive looks up, "
      "right, or\n"
      "                       is turned clockwise; once for each axis\n"
      "  --range-offset MM    the PMD camera measures so much too far\n";
  static const std::string text = [] {
    std::string all(kScenes);
    all += rig_usage();
    all += board_usage();
    return all;
  }();
  return text;
}

std::expected<emu::Rig, std::string> seen_rig(const SceneOptions& options) {
  if (emu::is_board(options.name)) {
    if (std::expected<emu::Board, std::string> board = emu::parse_board(options.name); !board) {
      return std::unexpected(std::move(board.error()));
    }
  } else if (options.board.poses || options.board.speed_m_s > 0) {
    return std::unexpected(
        "--poses and --speed: the scene is no board; take --scene board:chess,9x6,0.04");
  }
  return try_changed(own_rig(options.name), options);
}

bool moves(const SceneOptions& options) {
  return options.name == "walking" || options.name == "leaving" || emu::is_board(options.name) ||
         renders_as_it_goes(options);
}

bool renders_as_it_goes(const SceneOptions& options) { return options.name.starts_with(kDrive); }

namespace {

BoardWorld board_of(const SceneOptions& options, const emu::BoardTimes& times) {
  const std::expected<emu::Board, std::string> board = emu::parse_board(options.name);
  STOF_CHECK(board.has_value());
  return board_world(*board, changed(board_rig(), options), options.board, times);
}

}  // namespace

std::int32_t after_pair_us(const emu::ExposureTimes& times) {
  return static_cast<std::int32_t>(std::lround((times.pmd - times.pair) / 2 * 1e6));
}

SceneWorld render_ideal(const SceneOptions& options) {
  SceneOptions ideal = options;
  ideal.rig.rectified = true;
  return render_world(ideal);
}

BoardWorld render_poses(const SceneOptions& options, int frames) {
  return board_of(options, {.exposures = options.times, .hold = frames, .moves = 0});
}

SceneWorld render_world(const SceneOptions& options) {
  if (const std::optional<emu::FloorView> view = floor_view(options.name)) {
    return floor_world(*view, options);
  }
  if (const std::optional<DriveThrough> drive = drive_through(options.name)) {
    const StillScene still = still_scene(drive->scene, options);
    return {.imagery = std::make_unique<emu::DrivenScene>(still.scene, still.rig, drive->speed,
                                                          options.times)};
  }
  if (emu::is_board(options.name)) {
    return {.imagery = board_of(options, {.exposures = options.times,
                                          .hold = options.board.hold,
                                          .moves = options.board.moves})
                           .imagery};
  }
  if (moves(options)) {
    emu::Motion motion = options.name == "walking" ? emu::walking() : emu::leaving();
    motion.pmd_every = options.times.pmd_every;
    return {.imagery =
                std::make_unique<emu::MovingScene>(motion, changed(emu::corridor_rig(), options))};
  }
  const StillScene still = still_scene(options.name, options);
  return {.imagery = std::make_unique<emu::RenderedScene>(still.scene, still.rig)};
}

}  // namespace stof::board
