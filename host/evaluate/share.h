#pragma once

#include <cstddef>
#include <optional>

namespace stof::host {

// The share of what was counted that is of one kind, 0..1; none of nothing.
class Share {
 public:
  void count(bool is_of_kind) {
    of_kind_ += is_of_kind ? 1U : 0U;
    ++counted_;
  }
  std::size_t counted() const { return counted_; }
  std::optional<double> value() const {
    return counted_ == 0
               ? std::nullopt
               : std::optional(static_cast<double>(of_kind_) / static_cast<double>(counted_));
  }

 private:
  std::size_t of_kind_ = 0;
  std::size_t counted_ = 0;
};

}  // namespace stof::host
