#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "dataset/image.h"
#include "host/calibrate/rig/exchange/exchange.h"

namespace stof::host {

// Takes numbers out of a YAML document and remembers the first thing that was missing or wrong,
// with its line; from then on every number is 0.
class YamlReader {
 public:
  // OpenCV's `%YAML:1.0` counts as YAML, and so does JSON.
  static dataset::Loaded<YamlReader> of(const NamedText& named);

  const std::filesystem::path& file() const { return file_; }
  bool has(const char* key) const { return root_[key].IsDefined(); }
  YAML::Node at(const char* key);  // undefined when it is not there: fail()ed
  YAML::Node in(const YAML::Node& parent, const char* key);

  // `least` to `most` numbers of a sequence, or of an OpenCV or ROS matrix ({rows, cols, data}),
  // which has as many as rows and columns say.
  std::vector<double> numbers(const YAML::Node& node, const char* name, std::size_t least,
                              std::size_t most);
  // Rows of `columns` numbers.
  std::vector<double> rows(const YAML::Node& node, const char* name, std::size_t count,
                           std::size_t columns);
  int integer(const YAML::Node& node, const char* name);
  std::string word(const YAML::Node& node, const char* name);  // printable, short

  void fail(const YAML::Node& node, std::string what, std::string remedy);
  bool failed() const { return !problem_.message.empty(); }
  const dataset::Problem& problem() const { return problem_; }

 private:
  YamlReader(std::filesystem::path file, const YAML::Node& root)
      : file_(std::move(file)), root_(root) {}
  double number(const YAML::Node& node, const char* name);
  void require_rows(const YAML::Node& matrix, const char* name, std::size_t count);

  std::filesystem::path file_;
  YAML::Node root_;
  dataset::Problem problem_;
};

// A number that reads back to the same bits.
std::string exact(double value);
// "[a, b, c]".
std::string exact_list(const std::vector<double>& values);

}  // namespace stof::host
