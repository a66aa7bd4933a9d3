#pragma once

#include <cstdint>
#include <optional>

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/row_search.h"
#include "lab/block/adaptive.h"
#include "lab/block/match_blocks.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"
#include "lab/pyramid/pyramid.h"

namespace stof::lab {

// The searches that need the whole picture at once: blocks of their own shape, coarse to fine. The
// first row of a pair does all the work; the others are as they were found. Keeps no costs.
class MapSearch final : public RowSearch {
 public:
  static bool serves(const MatchParams& params) noexcept;

  // For pictures of exactly this size.
  MapSearch(const MatchParams& params, int width, int height, Arena& arena) noexcept;

  void start(const PreparedPair& pair, Guide guide) noexcept override;
  void match(int y, const MatchedRow& out) noexcept override;

 private:
  struct Shapes {
    Shapes(int width, int height, Arena& arena) noexcept
        : edges(arena.take_image<std::uint8_t>(width, height)),
          blocks(arena.take_image<Block>(width, height)),
          offers(width, height, arena) {}

    ImageView<std::uint8_t> edges;
    ImageView<Block> blocks;
    BlockOffers offers;
  };

  void search() noexcept;
  void match_shapes(const PreparedPair& pair) noexcept;

  MatchParams params_;
  std::optional<Shapes> shapes_;  // or
  std::optional<CoarseToFine> pyramid_;
  ImageView<std::int16_t> winners_;
  ImageView<std::int16_t> right_;  // of the right picture, where somebody asks for them
  const PreparedPair* pair_ = nullptr;
  bool searched_ = false;
};

}  // namespace stof::lab
