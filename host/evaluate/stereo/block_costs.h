#pragma once

#include "dataset/dataset.h"
#include "dsp/stereo/prepared_pair.h"
#include "host/evaluate/workspace.h"
#include "lab/cost/sum_rows.h"

namespace stof::host {

// Every block cost of a pair, row by row, in memory of its own.
template <typename Sum>
class BlockCosts {
 public:
  // Both are borrowed.
  BlockCosts(const dataset::StereoScene& scene, const lab::MatchParams& params)
      : scene_(scene), params_(params), space_(dsp::bytes_taken([this](dsp::Arena& arena) {
          dsp::PreparedPair(params_, width(), height(), arena);
          lab::SumRows<Sum>(params_, width(), arena);
        })) {}

  // Prefilters the pair, then calls use(row) from the first row to the last. A row is overwritten
  // by the next one.
  template <typename Use>
  void each_row(const Use& use) {
    dsp::Arena arena = space_.arena();
    dsp::PreparedPair pair(params_, width(), height(), arena);
    lab::SumRows<Sum> rows(params_, width(), arena);
    pair.start(scene_.left.view(), scene_.right.view());
    pair.filter({0, height()});
    pair.derive({0, height()});
    rows.start(pair);
    for (int y = 0; y < height(); ++y) {
      use(rows.row(y));
    }
  }

 private:
  int width() const { return scene_.left.width; }
  int height() const { return scene_.left.height; }

  const dataset::StereoScene& scene_;
  const lab::MatchParams& params_;
  Workspace space_;
};

}  // namespace stof::host
