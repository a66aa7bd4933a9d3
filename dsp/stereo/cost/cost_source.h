#pragma once

#include <span>

namespace stof::dsp {

// Where rows of costs come from, laid out [column][candidate] as in sad.h.
template <typename Cost>
class CostSource {
 public:
  // Row y of the current picture. Rows are asked for in order, top down, but may begin anywhere
  // again.
  virtual void row(int y, std::span<Cost> costs) noexcept = 0;

 protected:
  ~CostSource() = default;
};

}  // namespace stof::dsp
