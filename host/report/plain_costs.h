#pragma once

#include <span>
#include <vector>

#include "dataset/dataset.h"
#include "dsp/stereo/cost/cost_layout.h"
#include "lab/match_params.h"

namespace stof::host {

// The clipped derivative of a picture, by the reference kernel.
dataset::Image<std::uint8_t> plain_derivative(const dataset::Image<std::uint8_t>& picture, int cap);

// Block costs of a pair, row by row, by the reference kernels alone: loops as the formulas are
// printed. SAD, SSD and both kinds of census. Sum is u32 where sums_fit_u16() does not allow u16.
template <typename Sum>
class PlainCosts {
 public:
  // Prefilters the pictures where the params ask for it.
  PlainCosts(const dataset::StereoScene& scene, const lab::MatchParams& params);

  int width() const { return left_.width; }
  int height() const { return left_.height; }
  int lanes() const { return lanes_; }

  // Row y, one after the other from 0: [column][candidate], kNoCost outside the right picture.
  // Valid until the next call.
  std::span<const Sum> row(int y);

 private:
  struct RowPair {
    std::vector<std::uint8_t> left;
    std::vector<std::uint8_t> right;
  };

  bool census() const;
  void mark_outside();
  void load(int y, RowPair& pair) const;
  std::vector<std::uint8_t>& kept(int y);
  void describe(const dataset::Image<std::uint8_t>& picture, int y,
                std::vector<std::uint8_t>& planes) const;
  void pixel_costs(int y, std::vector<std::uint8_t>& costs) const;
  void enter(int y);
  void exchange(int entering, int leaving);

  lab::MatchParams params_;
  int lanes_;
  dsp::CostColumns columns_;
  int widened_;  // columns with those beyond the borders
  dataset::Image<std::uint8_t> left_;
  dataset::Image<std::uint8_t> right_;
  RowPair new_;
  RowPair old_;
  std::vector<std::vector<std::uint8_t>> kept_;  // census: rows of pixel costs, by y
  std::vector<Sum> sums_;
  std::vector<Sum> costs_;
};

extern template class PlainCosts<std::uint16_t>;
extern template class PlainCosts<std::uint32_t>;

}  // namespace stof::host
