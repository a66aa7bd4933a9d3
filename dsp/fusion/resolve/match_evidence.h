#pragma once

#include <cstdint>

#include "dsp/base/fixed.h"
#include "dsp/base/image.h"
#include "dsp/calib/calibration.h"
#include "dsp/fusion/interval/stereo_interval.h"
#include "dsp/fusion/project/pmd_view.h"
#include "dsp/fusion/resolve/surface_ends.h"
#include "dsp/pmd/pmd_maps.h"

namespace stof::dsp {

// What a picture changes by around a pixel: the sum of the differences between the neighbours of 7
// pixels, fewer at its border, along the row or across it, whichever is more.
int contrast(ImageView<const std::uint8_t> picture, int x, int y) noexcept;

// Judges a match that no PMD interval confirms, or a surface that somebody else supposes. Two
// things are asked: what the PMD pixel that would see it has read, even if that reading may have
// wrapped and so has no distance (PmdMaps::folded); and, of a match, whether the matches around it
// lie on the same surface.
class MatchEvidence {
 public:
  enum class Verdict : std::uint8_t {
    kKept,          // nothing speaks against it; of a match: enough speaks for it
    kAllowed,       // of a surface: the PMD's reading may be one of it
    kConfirmed,     // the PMD's reading is one of it, a number of ranges away
    kContradicted,  // the PMD sees something else there
    kDoubtful,      // of a match: it may be of a surface beside it
    kUnsupported,   // nothing but the match speaks for it
  };
  // A match and its interval, quarter mm.
  struct Match {
    int x;
    int y;
    Disparity disparity;
    std::uint8_t ratio;  // peak ratio
    DepthInterval interval;
  };
  struct Result {
    Verdict verdict;
    DepthInterval reading;  // of kConfirmed: where the PMD's reading lies, 2 sigma and a margin
  };

  // infinity_raw: the disparity of infinity, 1/16 px.
  MatchEvidence(const Calibration& calibration, std::int16_t infinity_raw) noexcept;

  // What judge() asks, valid until the next call; nullptr: there are no PMD data.
  void look_at(const PmdMaps* pmd) noexcept { pmd_ = pmd; }

  // Whether judge() may be called: there are PMD data.
  bool judges() const noexcept { return pmd_ != nullptr; }

  // view: which holds the match.
  // Of the 16 matches 4 and 8 px around it, those within 3/4 px or a 24th of the parallax support a
  // match; bounds hold for 16, and for as many as the picture has there in proportion. With fewer
  // than 3 it is unsupported.
  // It is contradicted where the PMD pixel that sees it (3x3 of them, where they are wide) says
  // something, and none of this:
  //   its interval begins before the match's far end (something nearer may hide the match);
  //   its folded reading plus any number of ranges is within 2 sigma and the match's own half
  //   width, at most a twentieth of the distance, of it. Where that is more than an eighth of the
  //   range to either side, a folded reading says nothing: it would agree by chance.
  // Where a PMD pixel sees it, 12 are needed, or 6 of a match with a peak ratio below kSureRatio or
  // with a folded reading that agrees; such a reading confirms it, but not that of a wide pixel
  // with kPmdEdge.
  // The margin of a reading that confirms it is a percent.
  // Beside a fine PMD camera a match that no reading confirms may be of what is near, beyond its
  // edge. It is doubtful where its support, with more of it the more the picture changes there, the
  // less distinct it is, and the more the picture says that it lies beyond an edge
  // (beyond_edge()), is not enough (is_beyond_doubt() in the source).
  Result judge(const Match& match, const MatchedView& view) const noexcept;

  // Whether a surface at Z `depth`, quarter mm, may be what pixel (x, y) of the left view shows:
  //   kConfirmed     the folded reading there is one of it, within 2 sigma and a twentieth of the
  //                  distance; the margin is 3 percent. Not of wide PMD pixels, which see several
  //   kAllowed       so is what is read there (or in one of 3x3, where PMD pixels are wide)
  //   kKept          nothing is read there, or too little to tell
  //   kContradicted  the PMD sees something else there, behind it or before it
  Result judge_surface(int x, int y, QuarterMm depth) const noexcept;

 private:
  enum class Opinion : std::uint8_t { kNone, kAgrees, kDiffers };
  // What a PMD pixel says.
  struct Said {
    Opinion opinion = Opinion::kNone;
    bool folded = false;
    bool hidden = false;  // agrees, if what the interval holds hides it
    float off = 0;        // folded: by how much it is off
    float sigma = 0;      // folded
  };
  Said ask(int column, int row, float distance, float half) const noexcept;
  // What place and those around it say, that are asked too.
  template <typename Hear>
  void ask_around(const PmdView::Place& place, float half, Hear hear) const noexcept;
  struct Support {
    int count = 0;    // of matches that support it
    int there = 0;    // pixels of the picture that might
    int missing = 0;  // of those near it, that have no match
    bool is_enough(int of_sixteen) const noexcept { return 16 * count >= of_sixteen * there; }
  };
  bool is_beyond_doubt(const Match& match, const MatchedView& view, const Support& support,
                       bool outside) const noexcept;
  int most_of(const Match& match) const noexcept;
  Support supporters(const Match& match, ImageView<const Disparity> disparity) const noexcept;
  static Support inner_supporters(const Match& match, int most,
                                  ImageView<const Disparity> disparity) noexcept;

  PmdView view_;
  std::int16_t infinity_raw_ = 0;
  int around_ = 0;  // PMD pixels to each side that are asked too
  const PmdMaps* pmd_ = nullptr;
};

}  // namespace stof::dsp
