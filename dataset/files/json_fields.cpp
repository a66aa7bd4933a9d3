#include "dataset/files/json_fields.h"

#include <algorithm>
#include <cmath>

namespace stof::dataset {

using nlohmann::json;

double Fields::number(const char* key) {
  const json::const_iterator at = root_.find(key);
  if (at == root_.end()) {
    return fail(std::string("has no \"") + key + "\"");
  }
  return number_at(*at, key);
}

int Fields::integer(const char* key, int low, int high) {
  const double value = number(key);
  if (wrong_.empty() && (value != std::floor(value) || value < low || value > high)) {
    fail(std::string("has a \"") + key + "\" that is not a whole number from " +
         std::to_string(low) + " to " + std::to_string(high));
  }
  return wrong_.empty() ? static_cast<int>(value) : 0;
}

void Fields::numbers(const char* key, std::span<double> out) {
  std::size_t used = 0;
  const json::const_iterator at = root_.find(key);
  if (at != root_.end() && at->is_array()) {
    for (const json& entry : *at) {
      collect(entry, key, out, used);
    }
  }
  if (used != out.size()) {
    fail(std::string("has no \"") + key + "\" of " + std::to_string(out.size()) + " numbers");
  }
}

int Fields::triples(const char* key, std::span<std::array<double, 3>> out) {
  const json::const_iterator at = root_.find(key);
  const bool fits = at != root_.end() && at->is_array() && at->size() <= out.size();
  if (!fits || !std::ranges::all_of(
                   *at, [](const json& row) { return row.is_array() && row.size() == 3; })) {
    fail(std::string("has no \"") + key + "\" of at most " + std::to_string(out.size()) +
         " rows of 3 numbers");
    return 0;
  }
  for (std::size_t i = 0; i < at->size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      out[i][k] = number_at((*at)[i][k], key);
    }
  }
  return static_cast<int>(at->size());
}

std::size_t Fields::word(const char* key, std::span<const char* const> words) {
  const json::const_iterator at = root_.find(key);
  const json::string_t* const text =
      at != root_.end() ? at->get_ptr<const json::string_t*>() : nullptr;
  for (std::size_t i = 0; text != nullptr && i < words.size(); ++i) {
    if (*text == words[i]) {
      return i;
    }
  }
  fail(std::string("has an unknown \"") + key + "\"");
  return 0;
}

void Fields::require(bool condition, const char* otherwise) {
  if (!condition) {
    fail(otherwise);
  }
}

double Fields::fail(std::string what) {
  if (wrong_.empty()) {
    wrong_ = std::move(what);
  }
  return 0;
}

double Fields::number_at(const json& value, const char* key) {
  const double* const real = value.get_ptr<const json::number_float_t*>();
  if (real != nullptr && std::isfinite(*real)) {
    return *real;
  }
  if (const auto* natural = value.get_ptr<const json::number_unsigned_t*>()) {
    return static_cast<double>(*natural);
  }
  if (const auto* integer = value.get_ptr<const json::number_integer_t*>()) {
    return static_cast<double>(*integer);
  }
  return fail(std::string("has a \"") + key + "\" that is not a number");
}

void Fields::collect(const json& entry, const char* key, std::span<double> out, std::size_t& used) {
  if (entry.is_array()) {
    for (const json& inner : entry) {
      if (used < out.size() && !inner.is_array()) {
        out[used] = number_at(inner, key);
      }
      ++used;
    }
    return;
  }
  if (used < out.size()) {
    out[used] = number_at(entry, key);
  }
  ++used;
}

std::string problem_of(dsp::Calibration calibration, bool has_rig) {
  if (!has_rig) {
    calibration.stereo = {.left = {.fx = 1, .fy = 1}, .baseline_m = 1};
    calibration.pmd_to_stereo = {};
  }
  if (calibration.stereo.left.width == 0 || calibration.stereo.left.height == 0) {
    calibration.stereo.left.width = calibration.stereo.left.height = kMaxSide;
  }
  return dsp::problem(calibration);
}

}  // namespace stof::dataset
