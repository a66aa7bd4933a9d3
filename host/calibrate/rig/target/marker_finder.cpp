#include "host/calibrate/rig/target/marker_finder.h"

#include <algorithm>
#include <cmath>

#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "dsp/base/index.h"

namespace stof::host {
namespace {

using dsp::index;

constexpr int kAprilBorder = 2;  // cells
constexpr int kMostTimes = 3;    // by which a picture is enlarged
constexpr int kSmallestWindow = 2;
constexpr int kLargestWindow = 8;
constexpr double kWrong = 0.5;       // of a square: a corner that lies so far off is another
constexpr double kLeastAgree = 0.8;  // of the corners

using Quad = std::array<cv::Point2f, 4>;  // upper left, upper right, lower right, lower left

struct SeenMarker {
  BoardMarker marker;
  Quad corners;
};

// The smallest of OpenCV's dictionaries that has as many markers: the fewer, the more wrong bits
// can be corrected.
cv::Ptr<cv::aruco::Dictionary> dictionary_of(const Board& board, std::size_t markers) {
  if (board.kind == Board::Kind::kAprilGrid) {
    return cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
  }
  constexpr std::array<std::size_t, 4> kSizes{50, 100, 250, 1000};
  constexpr int kSmallestBits = 4;
  const auto size = std::ranges::find_if(kSizes, [&](std::size_t n) { return n >= markers; });
  const auto nth = std::min<std::ptrdiff_t>(size - kSizes.begin(), kSizes.size() - 1);
  const int first = cv::aruco::DICT_4X4_50 + 4 * (board.bits - kSmallestBits);
  return cv::aruco::getPredefinedDictionary(first + static_cast<int>(nth));
}

// Those of the picture, `times` as large, that are not yet among the markers seen; places are those
// of the picture as it is.
void add_seen(const cv::Mat& picture, const Board& board, const std::vector<BoardMarker>& markers,
              int times, std::vector<SeenMarker>& seen) {
  const cv::Ptr<cv::aruco::DetectorParameters> how = cv::aruco::DetectorParameters::create();
  how->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
  how->markerBorderBits = board.kind == Board::Kind::kAprilGrid ? kAprilBorder : 1;
  how->minMarkerPerimeterRate = 0.01;  // of the picture's width
  cv::Mat large = picture;
  if (times > 1) {
    cv::resize(picture, large, {}, times, times, cv::INTER_CUBIC);
  }
  std::vector<int> ids;
  std::vector<std::vector<cv::Point2f>> found;
  cv::aruco::detectMarkers(large, dictionary_of(board, markers.size()), found, ids, how);
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const bool known = ids[i] >= 0 && index(ids[i]) < markers.size();
    const auto same = [id = ids[i]](const SeenMarker& one) { return one.marker.id == id; };
    // Twice seen is once wrong, and nobody knows when.
    if (!known || std::ranges::count(ids, ids[i]) != 1 || std::ranges::any_of(seen, same)) {
      continue;
    }
    SeenMarker marker{.marker = markers[index(ids[i])], .corners = {}};
    for (std::size_t k = 0; k < marker.corners.size(); ++k) {
      const auto scale = static_cast<float>(times);
      const cv::Point2f half(0.5F, 0.5F);  // of a pixel, whose centre has whole numbers
      marker.corners[k] = (found[i][k] + half) / scale - half;
    }
    seen.push_back(marker);
  }
}

// Cells of less than two pixels are read where the picture is enlarged.
std::vector<SeenMarker> seen_markers(const cv::Mat& picture, const Board& board) {
  const std::vector<BoardMarker> markers = markers_of(board);
  std::vector<SeenMarker> seen;
  for (int times = 1; times <= kMostTimes && seen.size() < markers.size(); ++times) {
    add_seen(picture, board, markers, times, seen);
  }
  return seen;
}

double side_of(const Quad& quad) {
  double shortest = HUGE_VAL;
  for (std::size_t i = 0; i < quad.size(); ++i) {
    const cv::Point2f step = quad[(i + 1) % quad.size()] - quad[i];
    shortest =
        std::min(shortest, std::hypot(static_cast<double>(step.x), static_cast<double>(step.y)));
  }
  return shortest;
}

// Where corners are by the markers beside them, and how large a marker is there, px.
struct Guess {
  double u = 0;
  double v = 0;
  int markers = 0;
  double side_px = HUGE_VAL;
};

// The corner that a place of a square or tag is, or -1: one of the outline.
int corner_of_square(const Board& board, int column, int row, int down, int right) {
  const int x = column - 1 + right;
  const int y = row - 1 + down;
  const bool inside = x >= 0 && y >= 0 && x < board.columns && y < board.rows;
  return inside ? y * board.columns + x : -1;
}

// A marker's own perspective, carried on to the corners of the square around it.
void add_charuco(const Board& board, const SeenMarker& seen, std::vector<Guess>& guesses) {
  const auto low = static_cast<float>((1 - board.share) / 2);
  const float high = 1 - low;
  const Quad inside{{{low, low}, {high, low}, {high, high}, {low, high}}};
  const cv::Mat carry = cv::getPerspectiveTransform(inside.data(), seen.corners.data());
  std::vector<cv::Point2f> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  cv::perspectiveTransform(square, square, carry);
  for (int k = 0; k < 4; ++k) {
    const int corner = corner_of_square(board, seen.marker.column, seen.marker.row, k / 2,
                                        k == 1 || k == 2 ? 1 : 0);
    if (corner >= 0) {
      Guess& guess = guesses[index(corner)];
      guess.u += static_cast<double>(square[index(k)].x);
      guess.v += static_cast<double>(square[index(k)].y);
      guess.side_px = std::min(guess.side_px, side_of(seen.corners));
      ++guess.markers;
    }
  }
}

std::vector<Guess> charuco_guesses(const Board& board, const std::vector<SeenMarker>& seen) {
  std::vector<Guess> guesses(index(board.corners()));
  for (const SeenMarker& marker : seen) {
    add_charuco(board, marker, guesses);
  }
  for (Guess& guess : guesses) {
    // Each corner touches two white squares: one marker alone is carried too far.
    constexpr int kBoth = 2;
    if (guess.markers == kBoth) {
      guess.u /= kBoth;
      guess.v /= kBoth;
    } else {
      guess.markers = 0;
    }
  }
  return guesses;
}

// `turn`: quarters by which the tags stand turned on the sheet against OpenCV's.
std::vector<Guess> april_guesses(const Board& board, const std::vector<SeenMarker>& seen,
                                 int turn) {
  std::vector<Guess> guesses(index(board.corners()));
  for (const SeenMarker& marker : seen) {
    for (int k = 0; k < 4; ++k) {
      const int place = (k + turn) % 4;
      const int column = 2 * marker.marker.column + (place == 1 || place == 2 ? 1 : 0);
      const int row = 2 * marker.marker.row + place / 2;
      const cv::Point2f& at = marker.corners[index(k)];
      guesses[index(row * board.columns + column)] = {.u = static_cast<double>(at.x),
                                                      .v = static_cast<double>(at.y),
                                                      .markers = 1,
                                                      .side_px = side_of(marker.corners)};
    }
  }
  return guesses;
}

// Those that one perspective explains to within half a square, the others taken away; the share
// that is left.
double keep_agreeing(const Board& board, std::vector<Guess>& guesses) {
  std::vector<cv::Point2f> on_board;
  std::vector<cv::Point2f> in_picture;
  std::vector<Guess*> of;
  double side_px = 0;
  for (int i = 0; i < board.corners(); ++i) {
    Guess& guess = guesses[index(i)];
    if (guess.markers > 0) {
      const std::array<double, 2> at = board.at(i);
      on_board.emplace_back(static_cast<float>(at[0]), static_cast<float>(at[1]));
      in_picture.emplace_back(static_cast<float>(guess.u), static_cast<float>(guess.v));
      of.push_back(&guess);
      side_px += guess.side_px;
    }
  }
  constexpr std::size_t kLeast = 4;
  if (of.size() < kLeast) {
    return 0;
  }
  side_px /= static_cast<double>(of.size());
  std::vector<std::uint8_t> agrees;
  cv::findHomography(on_board, in_picture, cv::RANSAC, kWrong * side_px, agrees);
  double kept = 0;
  for (std::size_t i = 0; i < of.size(); ++i) {
    const bool good = i < agrees.size() && agrees[i] != 0;
    of[i]->markers = good ? of[i]->markers : 0;
    kept += good ? 1 : 0;
  }
  return kept / static_cast<double>(of.size());
}

std::vector<Guess> guesses_of(const Board& board, const std::vector<SeenMarker>& seen) {
  if (board.kind == Board::Kind::kCharuco) {
    std::vector<Guess> guesses = charuco_guesses(board, seen);
    return keep_agreeing(board, guesses) >= kLeastAgree ? guesses : std::vector<Guess>{};
  }
  std::vector<Guess> best;
  double most = kLeastAgree;
  for (int turn = 0; turn < 4; ++turn) {
    std::vector<Guess> guesses = april_guesses(board, seen, turn);
    const double share = keep_agreeing(board, guesses);
    if (share >= most) {
      most = share;
      best = std::move(guesses);
    }
  }
  return best;
}

// Half the side of the window around a corner that shows nothing but the four squares that meet
// there, however the board is turned: the next thing begins as far away along both sides.
int window_of(const Board& board, double marker_px) {
  constexpr double kBorderShare = 0.2;  // of a tag: two cells of ten
  const double free = board.kind == Board::Kind::kCharuco ? (1 - board.share) / 2 / board.share
                                                          : std::min(kBorderShare, board.share);
  return std::clamp(static_cast<int>(free * marker_px), kSmallestWindow, kLargestWindow);
}

void refine(const cv::Mat& picture, const Board& board, const std::vector<Guess>& guesses,
            std::vector<PixelPoint>& corners) {
  constexpr int kMostSteps = 60;
  constexpr double kSmallestStep = 1e-3;
  for (std::size_t i = 0; i < guesses.size(); ++i) {
    const Guess& guess = guesses[i];
    const int half = window_of(board, guess.side_px);
    const bool inside = guess.u > half + 1 && guess.v > half + 1 &&
                        guess.u < picture.cols - half - 2 && guess.v < picture.rows - half - 2;
    if (guess.markers == 0 || !inside) {
      continue;
    }
    std::vector<cv::Point2f> point{{static_cast<float>(guess.u), static_cast<float>(guess.v)}};
    cv::cornerSubPix(picture, point, cv::Size(half, half), cv::Size(-1, -1),
                     cv::TermCriteria(cv::TermCriteria::EPS | cv::TermCriteria::COUNT, kMostSteps,
                                      kSmallestStep));
    const PixelPoint found{.u = static_cast<double>(point[0].x),
                           .v = static_cast<double>(point[0].y),
                           .uu = kRoughPx * kRoughPx,
                           .vv = kRoughPx * kRoughPx};
    if (std::hypot(found.u - guess.u, found.v - guess.v) <= half) {
      corners[i] = found;
    }
  }
}

bool enough(const Board& board, const std::vector<PixelPoint>& corners) {
  std::vector<bool> columns(index(board.columns));
  std::vector<bool> rows(index(board.rows));
  int seen = 0;
  for (int i = 0; i < board.corners(); ++i) {
    if (corners[index(i)].seen()) {
      ++seen;
      columns[index(i % board.columns)] = true;
      rows[index(i / board.columns)] = true;
    }
  }
  constexpr int kLeastLines = 3;
  return seen >= kFewestSeen && std::ranges::count(columns, true) >= kLeastLines &&
         std::ranges::count(rows, true) >= kLeastLines;
}

}  // namespace

MarkerCells cells_of(const Board& board, int id) {
  const cv::Ptr<cv::aruco::Dictionary> dictionary = dictionary_of(board, markers_of(board).size());
  const int border = board.kind == Board::Kind::kAprilGrid ? kAprilBorder : 1;
  const int bits = dictionary->markerSize;
  const cv::Mat white =
      cv::aruco::Dictionary::getBitsFromByteList(dictionary->bytesList.rowRange(id, id + 1), bits);
  MarkerCells cells{.side = bits + 2 * border, .black = {}};
  for (int y = -border; y < bits + border; ++y) {
    for (int x = -border; x < bits + border; ++x) {
      const bool inside = x >= 0 && y >= 0 && x < bits && y < bits;
      cells.black.push_back(!inside || white.at<std::uint8_t>(y, x) == 0);
    }
  }
  return cells;
}

std::optional<FoundBoard> find_marked_board(const dataset::Image<std::uint8_t>& picture,
                                            const Board& board) {
  // Borrowed: OpenCV's pictures are not read-only, and these functions only read.
  const cv::Mat grey(picture.height, picture.width, CV_8UC1,
                     const_cast<std::uint8_t*>(picture.pixels.data()));
  const std::vector<Guess> guesses = guesses_of(board, seen_markers(grey, board));
  FoundBoard found{.corners = {}, .blur_px = std::numeric_limits<double>::quiet_NaN()};
  found.corners.assign(index(board.corners()), kUnseen);
  refine(grey, board, guesses, found.corners);
  if (!enough(board, found.corners)) {
    return std::nullopt;
  }
  return found;
}

}  // namespace stof::host
