// Interest operators: only positions that stand out are matched.
#include "lab/block/interest.h"

#include <algorithm>
#include <array>

#include "dsp/stereo/prefilter/prefilter.h"
#include "host/report/page/legend.h"
#include "host/report/stereo/sections.h"

namespace stof::host {
namespace {

// Of the derivative: wide, so that what stands out differs from what stands out more.
constexpr int kCap = 63;
constexpr double kSparse = 0.1;  // of all pairs
constexpr double kFast = 0.5;    // of the time for all positions

struct Masks {
  dataset::Image<std::uint8_t> left;
  dataset::Image<std::uint8_t> right;
};

dataset::Image<std::uint8_t> derivative(const dataset::Image<std::uint8_t>& picture, int cap) {
  dataset::Image<std::uint8_t> result(picture.width, picture.height);
  const dsp::ImageView<const std::uint8_t> rows = picture.view();
  for (int y = 0; y < picture.height; ++y) {
    dsp::best::clipped_sobel(rows.row_clamped(y - 1), rows.row(y), rows.row_clamped(y + 1), cap,
                             result.view().row(y));
  }
  return result;
}

// The positions that MatchParams::interest leaves.
Masks masks_of(const dataset::StereoScene& scene, const lab::MatchParams& params) {
  Masks masks{.left = {scene.left.width, scene.left.height, 1},
              .right = {scene.left.width, scene.left.height, 1}};
  if (!params.interest) {
    return masks;
  }
  const int cap = *params.prefilter_cap;
  const dataset::Image<std::uint8_t> left = derivative(scene.left, cap);
  const dataset::Image<std::uint8_t> right = derivative(scene.right, cap);
  for (int y = 0; y < scene.left.height; ++y) {
    if (*params.interest == lab::Interest::kMaxima) {
      lab::interest_maxima(left.view().row(y), cap, (cap + 1) / 2, masks.left.view().row(y));
      lab::interest_maxima(right.view().row(y), cap, (cap + 1) / 2, masks.right.view().row(y));
    } else {
      lab::interest_above(left.view().row(y), cap, (2 * cap + 2) / 3, masks.left.view().row(y));
      lab::interest_above(right.view().row(y), cap, (cap + 2) / 3, masks.right.view().row(y));
    }
  }
  return masks;
}

// Pairs of positions that are compared, of all candidates inside the right picture.
double share_of_pairs(const Masks& masks, int disparities) {
  double kept = 0;
  double all = 0;
  for (int y = 0; y < masks.left.height; ++y) {
    for (int x = 0; x < masks.left.width; ++x) {
      for (int d = 0; d < disparities && d <= x; ++d) {
        all += 1;
        kept += masks.left.view().at(x, y) != 0 && masks.right.view().at(x - d, y) != 0 ? 1 : 0;
      }
    }
  }
  return all > 0 ? kept / all : 0;
}

dataset::Image<Rgb> positions(const dataset::Image<std::uint8_t>& picture,
                              const dataset::Image<std::uint8_t>& mask) {
  constexpr Rgb kMark{214, 48, 49};
  dataset::Image<Rgb> drawn = as_colour(picture, true);
  for (std::size_t i = 0; i < drawn.pixels.size(); ++i) {
    drawn.pixels[i] = mask.pixels[i] != 0 ? kMark : drawn.pixels[i];
  }
  return drawn;
}

struct Choice {
  const char* name;
  std::optional<lab::Interest> interest;
};
constexpr std::array<Choice, 3> kChoices{{{"all", std::nullopt},
                                          {"(a) maxima", lab::Interest::kMaxima},
                                          {"(b) two thresholds", lab::Interest::kTwoThresholds}}};

// What all scenes say.
struct InterestTally {
  int judged = 0;
  int sparse = 0;
  int faster = 0;
  double least = 0;  // time against that of all positions
  double most = 0;
};

std::vector<Figure> add_interest_scene(Study& study, const Subject& subject, Table& table,
                                       InterestTally& tally) {
  const dataset::StereoScene& scene = subject.scene;
  std::vector<Figure> figures;
  table.rows.push_back({scene.name});
  std::optional<double> dense_ms;
  for (const Choice& choice : kChoices) {
    lab::MatchParams params = block_match(scene, lab::Cost::kSad, 16, 16, true);
    params.left_right_tolerance = 1;
    params.prefilter_cap = kCap;
    params.interest = choice.interest;
    const std::string name = choice.name;
    const std::optional<Outcome> outcome = study.run(scene, {"interest operator, " + name, params});
    if (!outcome) {
      continue;
    }
    const Masks masks = masks_of(scene, params);
    const double pairs = share_of_pairs(masks, scene.ndisp);
    table.rows.push_back({name, percent(pairs), percent(outcome->score.density),
                          percent(outcome->score.of_valid), number(outcome->ms, 2)});
    if (!choice.interest) {
      dense_ms = outcome->ms;
      continue;
    }
    ++tally.judged;
    tally.sparse += pairs < kSparse ? 1 : 0;
    const double times = dense_ms ? outcome->ms / *dense_ms : 1;
    tally.faster += times < kFast ? 1 : 0;
    tally.least = tally.judged == 1 ? times : std::min(tally.least, times);
    tally.most = std::max(tally.most, times);
    figures.push_back(
        figure(positions(scene.left, masks.left), scene.name + ", " + name + ", left positions",
               "Positions that are matched.", colour_legend({{{214, 48, 49}, "matched"}})));
    figures.push_back(map_figure(subject, outcome->disparity, scene.name + ", " + name,
                                 percent(outcome->score.density) + " % dense, " +
                                     percent(outcome->score.of_valid) +
                                     " % of the disparities bad."));
  }
  return figures;
}

}  // namespace

void add_interest(Study& study, Page& page) {
  page.begin_section("interest", "Interest operators");
  page.paragraph(
      "Only positions where the horizontal derivative stands out are matched, and only with "
      "positions of the right picture that stand out too. (a) maxima of the derivative along the "
      "row, in both pictures; (b) a higher threshold on the left and a lower one on the right. SAD "
      "16 × 16 on derivatives (cap 63), left-right check.");
  Table table{.caption = "Shares in percent",
              .header = {"Positions", "pairs compared", "density", "bad of valid", "ms"}};
  InterestTally tally;
  std::vector<Figure> figures;  // of the first scene
  for (const Subject& subject : study.subjects()) {
    std::vector<Figure> found = add_interest_scene(study, subject, table, tally);
    figures = figures.empty() ? std::move(found) : figures;
  }
  page.table(table);
  page.claim(
      {.chapter = "An interest operator makes matching sparse and thereby fast.",
       .measured = tally.judged == 0
                       ? "Nothing to compare."
                       : "It leaves less than a tenth of the pairs in " +
                             std::to_string(tally.sparse) + " of " + std::to_string(tally.judged) +
                             " cases, and takes " + number(tally.least, 1) + " to " +
                             number(tally.most, 1) +
                             " times as long as matching all positions: with running sums and "
                             "vectors a cost is nearly free wherever it is computed; leaving "
                             "pairs out saves time where every pair is summed anew.",
       .rule = "yes: a tenth of the pairs and half the time, always; partly: one of both, or "
               "sometimes.",
       .verdict = verdict_of(tally.sparse + tally.faster, 2 * tally.judged)});
  page.figures(figures, Width::kSmall);
}

}  // namespace stof::host
