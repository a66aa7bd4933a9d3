#pragma once

#include <vector>

#include "dsp/base/target.h"

namespace stof::test {

// What best:: kernels can run with on this processor: a test compares each with the reference.
inline std::vector<dsp::Vectors> all_vectors() {
  std::vector<dsp::Vectors> all;
  for (const dsp::Vectors vectors :
       {dsp::Vectors::kNeon, dsp::Vectors::kAvx2, dsp::Vectors::kAvx512}) {
    if (vectors <= dsp::widest_vectors()) {
      all.push_back(vectors);
    }
  }
  return all;
}

// best:: kernels run with these in its scope.
class UseVectors {
 public:
  explicit UseVectors(dsp::Vectors vectors) { dsp::use_vectors(vectors); }
  ~UseVectors() { dsp::use_vectors(dsp::widest_vectors()); }
  UseVectors(const UseVectors&) = delete;
  UseVectors& operator=(const UseVectors&) = delete;
};

}  // namespace stof::test
