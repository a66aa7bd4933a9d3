#pragma once

#include "dsp/base/arena.h"
#include "dsp/base/image.h"
#include "dsp/stereo/row_search.h"
#include "lab/dsp_names.h"
#include "lab/match_params.h"

namespace stof::lab {

// The lab's searches for a Matcher: those of MatchParams that the appliance does not serve.
class Searches final : public SearchMaker {
 public:
  // continued: of the pictures' largest size where params ask for kDynamicProgramming, which marks
  // there what it made up (search/cost_search.h); else empty.
  Searches(const MatchParams& params, ImageView<std::uint8_t> continued) noexcept
      : params_(params), continued_(continued) {}

  RowSearch* make(const dsp::MatchParams& params, int width, int height,
                  Arena& arena) noexcept override;
  int rows_at_once(int height) const noexcept override;

 private:
  template <typename Sum>
  RowSearch* make_cost_search(int width, Arena& arena) const noexcept;

  MatchParams params_;
  ImageView<std::uint8_t> continued_;
  // A search of whole maps is one for all threads, of which one does everything.
  bool made_ = false;
  RowSearch* map_search_ = nullptr;
};

}  // namespace stof::lab
