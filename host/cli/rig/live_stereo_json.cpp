#include "host/cli/rig/live_stereo_json.h"

#include <algorithm>
#include <cmath>

#include "host/calibrate/rig/live/corner_cells.h"
#include "host/cli/json_output.h"
#include "host/picture/png.h"
#include "host/report/page/page.h"

namespace stof::host {
namespace {

using Json = nlohmann::ordered_json;

// To a hundredth: nobody draws finer.
Json places_json(const std::vector<PixelPoint>& corners) {
  constexpr double kHundredth = 100;
  Json places = Json::array();
  for (const PixelPoint& corner : corners) {
    if (corner.seen()) {
      places.push_back({std::round(corner.u * kHundredth) / kHundredth,
                        std::round(corner.v * kHundredth) / kHundredth});
    }
  }
  return places;
}

const char* verdict_name(ViewVerdict verdict) {
  switch (verdict) {
    case ViewVerdict::kNoBoard:
      return "no_board";
    case ViewVerdict::kMoving:
      return "moving";
    case ViewVerdict::kBlurred:
      return "blurred";
    case ViewVerdict::kKnown:
      return "known";
    case ViewVerdict::kNeedless:
      return "needless";
    case ViewVerdict::kTaken:
      return "taken";
  }
  return "";
}

std::string picture_text(const dataset::Image<std::uint8_t>& picture, int width) {
  return base64(png_bytes(smaller_picture(picture, (picture.width + width - 1) / width)));
}

}  // namespace

dataset::Image<std::uint8_t> smaller_picture(const dataset::Image<std::uint8_t>& picture, int by) {
  dataset::Image<std::uint8_t> small(picture.width / by, picture.height / by);
  for (int y = 0; y < small.height; ++y) {
    for (int x = 0; x < small.width; ++x) {
      int sum = 0;
      for (int v = 0; v < by; ++v) {
        for (int u = 0; u < by; ++u) {
          sum +=
              picture.pixels[static_cast<std::size_t>((y * by + v) * picture.width + x * by + u)];
        }
      }
      small.pixels[static_cast<std::size_t>(y * small.width + x)] =
          static_cast<std::uint8_t>(sum / (by * by));
    }
  }
  return small;
}

Json stage_json(const char* state, const std::string& text) {
  return {{"state", state}, {"text", text}};
}

Json look_json(const LiveLook& look, int picture_width) {
  const int width = look.shot.left.width;
  const int height = look.shot.left.height;
  Json json = stage_json("looking", look.text);
  json["verdict"] = verdict_name(look.judgement.verdict);
  json["exposure"] = look.shot.exposure;
  json["size"] = {width, height};
  json["motion_px"] = number_or_null(look.judgement.motion_px);
  json["blur_px"] = number_or_null(look.judgement.blur_px);
  json["left"] = places_json(look.corners.left);
  json["right"] = places_json(look.corners.right);
  json["views"] = look.guide.views().size();
  Json wants = Json::array();
  for (const ViewWant& want : look.guide.wants()) {
    wants.push_back(
        {{"name", want.name}, {"ask", want.ask}, {"have", want.have}, {"need", want.need}});
  }
  json["wants"] = std::move(wants);
  const CornerCells cells = corner_cells(look.guide.views(), width, height);
  json["cells"] = {{"size", {CornerCells::kColumns, CornerCells::kRows}},
                   {"left", cells.left},
                   {"right", cells.right}};
  if (picture_width > 0) {
    json["left_png"] = picture_text(look.shot.left, picture_width);
    json["right_png"] = picture_text(look.shot.right, picture_width);
  }
  return json;
}

}  // namespace stof::host
