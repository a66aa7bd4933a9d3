// Adaptive blocks: what they look like, and what they do for edges.
#include "lab/block/adaptive.h"

#include <array>

#include "host/evaluate/stereo/match.h"
#include "host/report/page/legend.h"
#include "host/report/stereo/sections.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

constexpr int kMostWidth = 60;  // the largest block, px
constexpr int kMostHeight = 20;

struct Shape {
  const char* name;
  lab::BlockShape shape;
};
constexpr std::array<Shape, 3> kShapes{{{"fixed 60 × 20", lab::BlockShape::kFixed},
                                        {"cross", lab::BlockShape::kCross},
                                        {"region", lab::BlockShape::kRegion}}};

lab::MatchParams params_of(const dataset::StereoScene& scene, lab::BlockShape shape) {
  lab::MatchParams params = block_match(scene, lab::Cost::kSad, kMostWidth, kMostHeight, true);
  params.block_shape = shape;
  return params;
}

// The blocks of every pixel, as the matcher grows them.
dataset::Image<lab::Block> adaptive_blocks(const dataset::Image<std::uint8_t>& picture,
                                           lab::BlockShape shape) {
  const lab::AdaptiveParams params{
      .shape = shape, .max_width = kMostWidth, .max_height = kMostHeight};
  dataset::Image<std::uint8_t> edges(picture.width, picture.height);
  lab::mark_edges(picture.view(), params.edge, edges.view());
  dataset::Image<lab::Block> blocks(picture.width, picture.height);
  Workspace workspace(dsp::bytes_taken(
      [&](dsp::Arena& arena) { lab::Integral(picture.width, picture.height, arena); }));
  dsp::Arena arena = workspace.arena();
  lab::Integral integral(picture.width, picture.height, arena);
  lab::grow_blocks(edges.view(), params, integral, blocks.view());
  return blocks;
}

// The blocks about a grid of pixels, each in its own colour, drawn on the left picture twice as
// large.
dataset::Image<Rgb> drawn_blocks(const dataset::StereoScene& scene, lab::BlockShape shape) {
  constexpr std::array<Rgb, 6> kColours{{{255, 99, 72},
                                         {46, 213, 115},
                                         {64, 156, 255},
                                         {255, 200, 40},
                                         {232, 110, 255},
                                         {60, 225, 225}}};
  constexpr Rgb kOutline{12, 12, 14};
  constexpr int kFramePx = 3;
  constexpr int kOutlinePx = 5;
  constexpr int kColumns = 5;
  constexpr int kRows = 4;
  constexpr int kZoom = 2;
  const int width = scene.left.width;
  const int height = scene.left.height;
  const dataset::Image<lab::Block> blocks = adaptive_blocks(scene.left, shape);
  dataset::Image<std::uint8_t> large(kZoom * width, kZoom * height);
  for (int y = 0; y < large.height; ++y) {
    for (int x = 0; x < large.width; ++x) {
      large.view().at(x, y) = scene.left.view().at(x / kZoom, y / kZoom);
    }
  }
  dataset::Image<Rgb> picture = as_colour(large, false);
  for (int i = 0; i < kColumns * kRows; ++i) {
    const int column = i % kColumns;
    const int row = i / kColumns;
    const int x = (2 * column + 1) * width / (2 * kColumns);
    const int y = (2 * row + 1) * height / (2 * kRows);
    const lab::Block block = blocks.view().at(x, y);
    const Rgb colour = kColours[static_cast<std::size_t>(column + 2 * row) % kColours.size()];
    const auto frame = [&](int left, int up, int right, int down) {
      draw_frame(picture, kZoom * left, kZoom * up, kZoom * (right + 1) - 1, kZoom * (down + 1) - 1,
                 kOutlinePx, kOutline);
      draw_frame(picture, kZoom * left, kZoom * up, kZoom * (right + 1) - 1, kZoom * (down + 1) - 1,
                 kFramePx, colour);
    };
    frame(x - block.left, y - block.up, x + block.right, y + block.down);
    frame(x, y, x, y);
  }
  return picture;
}

// What all scenes say.
struct AdaptiveTally {
  int judged = 0;
  int better = 0;
  std::string list;

  void note(const std::string& scene, std::optional<double> fixed, std::optional<double> region) {
    if (fixed && region) {
      ++judged;
      better += *region < *fixed ? 1 : 0;
      add_to(list, scene + " " + percent(region) + " against " + percent(fixed), "; ");
    }
  }
};

void add_row(const std::string& name, const Outcome& outcome, Table& table) {
  table.rows.push_back({name, percent(outcome.score.near_edges), percent(outcome.score.visible),
                        percent(outcome.score.all), number(outcome.ms, 1)});
}

struct SceneFigures {
  std::vector<Figure> maps;
  std::vector<Figure> blocks;
};

SceneFigures add_adaptive_scene(Study& study, const Subject& subject, Table& table,
                                AdaptiveTally& tally) {
  const dataset::StereoScene& scene = subject.scene;
  SceneFigures figures;
  table.rows.push_back({scene.name});
  std::optional<double> fixed;
  std::optional<double> region;
  for (const Shape& shape : kShapes) {
    const std::string name = shape.name;
    const std::optional<Outcome> outcome =
        study.run(scene, {"adaptive blocks, " + name, params_of(scene, shape.shape)});
    if (!outcome) {
      continue;
    }
    add_row(name, *outcome, table);
    figures.maps.push_back(map_figure(subject, outcome->disparity, scene.name + ", " + name,
                                      in_words(*outcome) + "."));
    if (shape.shape == lab::BlockShape::kFixed) {
      fixed = outcome->score.near_edges;
    } else {
      figures.blocks.push_back(
          figure(drawn_blocks(scene, shape.shape), scene.name + ", " + name + " blocks",
                 "Blocks about 20 pixels of a grid; the small square is the pixel."));
    }
    if (shape.shape == lab::BlockShape::kRegion) {
      region = outcome->score.near_edges;
    }
  }
  if (const std::optional<Outcome> quality = study.run_preset(scene, "quality", true)) {
    add_row("preset quality, filled", *quality, table);
  }
  tally.note(scene.name, fixed, region);
  return figures;
}

}  // namespace

void add_adaptive(Study& study, Page& page) {
  page.begin_section("adaptive", "Adaptive blocks and edges");
  page.paragraph(
      "A block of at most 60 × 20 px grows about its pixel until it meets an edge: the cross "
      "method looks along the row and the column of the pixel, the region method adds whole rows "
      "and columns in turn. Near edges: not occluded pixels within 9 px of a step of the truth by "
      "more than 2 px. SAD on derivatives, winner takes all, dense.");
  Table table{.caption = "BP in percent",
              .header = {"Block", "BP near edges", "BP not occluded", "BP all", "ms"}};
  AdaptiveTally tally;
  std::vector<SceneFigures> figures;
  for (const Subject& subject : study.subjects()) {
    figures.push_back(add_adaptive_scene(study, subject, table, tally));
  }
  page.table(table);
  page.claim({.chapter = "Region blocks keep edges better than the fixed block of 60 × 20.",
              .measured = tally.judged == 0 ? "Nothing to compare."
                                            : "BP near edges in percent, region against fixed: " +
                                                  tally.list + ".",
              .rule = "yes: lower near edges in every scene; partly: in some.",
              .verdict = verdict_of(tally.better, tally.judged)});
  for (const SceneFigures& scene : figures) {
    page.figures(scene.maps, Width::kMedium);
    page.figures(scene.blocks, Width::kLarge);
  }
}

}  // namespace stof::host
