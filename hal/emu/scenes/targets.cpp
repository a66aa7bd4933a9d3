#include "hal/emu/scenes/targets.h"

#include "dsp/base/parse_number.h"

namespace stof::hal::emu {
namespace {

constexpr std::string_view kBars = "bars:";
constexpr std::string_view kStripes = "stripes:";

constexpr double kBarsZ = 1.5;
constexpr double kBehindBarsZ = 5;
constexpr double kStripesZ = 3;
constexpr double kWide = 20;  // more than any camera sees

// Its finest octave is three pixels of corridor_rig() wide.
constexpr Material kTexturedWall{
    .albedo = 0.75, .contrast = 0.6, .texture = Texture::kNoise, .period_m = 0.4, .seed = 5};
constexpr Material kBar{.albedo = 0.2, .nir = 0.3};

void put_wall(Scene& scene, double z, const Material& material) {
  add(scene, Shape::kRectangle, {0, 0, z}, {kWide, kWide, 0}, material);
}

Scene evenly_lit() {
  Scene scene;
  scene.ambient = 0.7;
  return scene;
}

}  // namespace

std::optional<Bars> parse_bars(std::string_view name) {
  const std::size_t comma = name.rfind(',');
  if (!name.starts_with(kBars) || comma == std::string_view::npos) {
    return std::nullopt;
  }
  const auto width = dsp::parse_number_in<double>(name.substr(kBars.size(), comma - kBars.size()),
                                                  kLeastBarPx, kMostBarPx);
  const std::string_view lie = name.substr(comma + 1);
  if (!width || (lie != "upright" && lie != "level")) {
    return std::nullopt;
  }
  return Bars{.width_px = *width, .level = lie == "level"};
}

std::optional<Stripes> parse_stripes(std::string_view name) {
  if (!name.starts_with(kStripes)) {
    return std::nullopt;
  }
  const std::string_view numbers = name.substr(kStripes.size());
  const std::size_t comma = numbers.find(',');
  const auto period =
      dsp::parse_number_in<double>(numbers.substr(0, comma), kLeastPeriodPx, kMostPeriodPx);
  Stripes stripes;
  if (period) {
    stripes.period_px = *period;
  }
  if (comma == std::string_view::npos) {
    return period ? std::optional(stripes) : std::nullopt;
  }
  const auto percent = dsp::parse_number_in<double>(numbers.substr(comma + 1), 0, 100);
  if (!period || !percent) {
    return std::nullopt;
  }
  stripes.contrast = *percent / 100;
  return stripes;
}

Scene bars_scene(const Bars& bars, const dsp::Pinhole& lens) {
  Scene scene = evenly_lit();
  put_wall(scene, kBehindBarsZ, kTexturedWall);
  const double half = bars.width_px * kBarsZ / lens.fx / 2;
  const double seen = (bars.level ? lens.height : lens.width) * kBarsZ / lens.fx;
  for (const double share : {-0.3, -0.1, 0.1, 0.3}) {
    if (bars.level) {
      add(scene, Shape::kRectangle, {0, share * seen, kBarsZ}, {kWide, half, 0}, kBar);
    } else {
      add(scene, Shape::kRectangle, {share * seen, 0, kBarsZ}, {half, kWide, 0}, kBar);
    }
  }
  return scene;
}

Scene stripes_scene(const Stripes& stripes, const dsp::Pinhole& lens) {
  Scene scene = evenly_lit();
  put_wall(scene, kStripesZ,
           {.albedo = 0.8,
            .contrast = stripes.contrast,
            .texture = Texture::kStripes,
            .period_m = stripes.period_px * kStripesZ / lens.fx,
            .nir = 0.6});
  return scene;
}

Rig target_rig() {
  Rig rig = corridor_rig();
  rig.left_camera_pose = {};
  return rig;
}

}  // namespace stof::hal::emu
