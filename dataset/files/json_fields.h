#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "dataset/pmd_recording.h"

// The common part of readers and writers of PMD recordings.
namespace stof::dataset {

inline constexpr int kMaxSide = 4096;  // of a picture

// Takes numbers out of one JSON document and remembers the first that was missing or wrong; from
// then on every number is 0.
class Fields {
 public:
  explicit Fields(const nlohmann::json& root) : root_(root) {}

  bool has(const char* key) const { return root_.contains(key); }
  double number(const char* key);
  double number_or(const char* key, double fallback) { return has(key) ? number(key) : fallback; }
  int integer(const char* key, int low, int high);
  int integer_or(const char* key, int low, int high, int fallback) {
    return has(key) ? integer(key, low, high) : fallback;
  }
  // `out.size()` numbers, flat or in rows of arrays.
  void numbers(const char* key, std::span<double> out);
  // Rows of three numbers, at most `most`; returns how many.
  int triples(const char* key, std::span<std::array<double, 3>> out);
  // One of `words`: its index.
  std::size_t word(const char* key, std::span<const char* const> words);
  void require(bool condition, const char* otherwise);
  const std::string& wrong() const { return wrong_; }

 private:
  double fail(std::string what);
  double number_at(const nlohmann::json& value, const char* key);
  void collect(const nlohmann::json& entry, const char* key, std::span<double> out,
               std::size_t& used);

  const nlohmann::json& root_;
  std::string wrong_;
};

// dsp::problem(). The size of the left picture, which a file need not know, and a missing rig are
// stood in for. Empty, or what is wrong.
std::string problem_of(dsp::Calibration calibration, bool has_rig);

// Numbers by their keys, in the order of the file.
template <typename T>
struct NumberKey {
  const char* key;
  double T::* value;
};
inline constexpr std::size_t kNeededLensKeys = 4;  // the others are 0 where a file has them not
inline constexpr std::array<NumberKey<dsp::Pinhole>, 9> kLensKeys{{{"fx", &dsp::Pinhole::fx},
                                                                   {"fy", &dsp::Pinhole::fy},
                                                                   {"cx", &dsp::Pinhole::cx},
                                                                   {"cy", &dsp::Pinhole::cy},
                                                                   {"k1", &dsp::Pinhole::k1},
                                                                   {"k2", &dsp::Pinhole::k2},
                                                                   {"k3", &dsp::Pinhole::k3},
                                                                   {"p1", &dsp::Pinhole::p1},
                                                                   {"p2", &dsp::Pinhole::p2}}};
inline constexpr std::array<NumberKey<dsp::PmdFrequency>, 4> kFrequencyKeys{
    {{"offset_m", &dsp::PmdFrequency::offset_m},
     {"offset_m_per_k", &dsp::PmdFrequency::offset_m_per_k},
     // Not "stray", which says what a simulated camera really has.
     {"stray_i_lsb", &dsp::PmdFrequency::stray_i_lsb},
     {"stray_q_lsb", &dsp::PmdFrequency::stray_q_lsb}}};
inline constexpr std::array<NumberKey<dsp::PmdSensor>, 4> kSensorKeys{
    {{"integration_us", &dsp::PmdSensor::integration_us},
     {"reference_c", &dsp::PmdSensor::reference_c},
     {"scale", &dsp::PmdSensor::scale},
     {"shift_m", &dsp::PmdSensor::shift_m}}};

// "fppn_unit": what the values of a fixed pattern count, from 32768.
enum class PatternUnit : std::uint8_t { kEighthMm, kTurn, kNone };
inline constexpr std::array<const char*, 3> kPatternUnits{"1/8 mm", "1/65536 turn", "none"};

// read_pmd(); usual_ratio is PmdFrequency::min_modulation_ratio of a json that has none.
Loaded<PmdRecording> read_recording(const std::filesystem::path& prefix,
                                    const std::optional<std::filesystem::path>& fixed_pattern,
                                    double usual_ratio);

}  // namespace stof::dataset
