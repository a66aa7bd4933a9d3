#pragma once

#include <string>
#include <vector>

#include "host/calibrate/rig/target/pair_fit.h"

// Whether views of a board can tell a rig's constants apart, and which view is missing.
namespace stof::host {

// How the board was held in one view, by the left camera.
struct ViewPose {
  double distance_m = 0;
  double share = 0;         // of the picture's area that the corners span, the larger of both eyes
  double sideways_rad = 0;  // tilt about the vertical: positive where the board's right side is
                            // farther
  double upwards_rad = 0;   // tilt about the horizontal: positive where its lower side is farther
};
ViewPose view_pose(const Board& board, const PairView& view, const PoseUnknowns& pose,
                   const dsp::RawPair& rig);

// What a set of views needs.
inline constexpr std::size_t kFewestBothViews = 8;  // seen by both eyes
inline constexpr double kNearShare = 0.1;           // of the picture's area: once at least
inline constexpr double kFarRatio = 0.6;       // the smallest square root of share to the largest
inline constexpr double kLeastTiltRad = 0.26;  // 15 degrees
inline constexpr int kLeastTilted = 2;         // views tilted sideways, and as many upwards
inline constexpr double kCornerShare = 0.25;   // of width and height: what a picture's corner is

// Which corners of both pictures some view reaches, a bit each.
unsigned reached_corners(const std::vector<PairView>& views, int width, int height);

// A line for each view that is missing, in the words of whoever holds the board; empty: all there.
std::vector<std::string> missing_views(const std::vector<PairView>& views,
                                       const std::vector<ViewPose>& poses, int width, int height);

}  // namespace stof::host
