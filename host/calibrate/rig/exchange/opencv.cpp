#include <array>
#include <string_view>

#include "dataset/files/file.h"
#include "host/calibrate/rig/exchange/exchange.h"
#include "host/calibrate/rig/exchange/lens_checks.h"
#include "host/text/printed.h"

namespace stof::host {
namespace {

// Both names that OpenCV's programs give a matrix.
struct Name {
  const char* brief;
  const char* whole;
};
constexpr std::array<Name, 2> kMatrices{{{"M1", "cameraMatrix1"}, {"M2", "cameraMatrix2"}}};
constexpr std::array<Name, 2> kDistortions{{{"D1", "distCoeffs1"}, {"D2", "distCoeffs2"}}};

// One or two files; a name may be in either.
class Files {
 public:
  explicit Files(std::vector<YamlReader> readers) : readers_(std::move(readers)) {}

  // Which fails where it is missing, or there twice.
  YamlReader& with(const Name& name, YAML::Node& node) {
    YamlReader* holder = nullptr;
    for (YamlReader& reader : readers_) {
      for (const char* const key : names_of(name)) {
        if (!reader.has(key)) {
          continue;
        }
        if (holder != nullptr) {
          reader.fail(reader.at(key), std::string("has ") + key + ", which is there twice",
                      "leave one of them");
          return reader;
        }
        holder = &reader;
        node.reset(reader.at(key));
      }
    }
    if (holder == nullptr) {
      holder = &readers_.back();
      node.reset(holder->at(name.brief));
    }
    return *holder;
  }
  YamlReader* failed() {
    for (YamlReader& reader : readers_) {
      if (reader.failed()) {
        return &reader;
      }
    }
    return nullptr;
  }
  // Of all files that have it; contradicting ones fail. 0: none has it.
  int integer(const char* key) {
    int value = 0;
    for (YamlReader& reader : readers_) {
      if (!reader.has(key)) {
        continue;
      }
      const YAML::Node node = reader.at(key);
      const int found = reader.integer(node, key);
      if (value != 0 && found != value && !reader.failed()) {
        reader.fail(node, printed("has another %s than the file before it", key),
                    "give files of one pair");
      }
      value = found;
    }
    return value;
  }

 private:
  static std::vector<const char*> names_of(const Name& name) {
    return std::string_view(name.brief) == name.whole ? std::vector{name.brief}
                                                      : std::vector{name.brief, name.whole};
  }

  std::vector<YamlReader> readers_;
};

void put_lens(Files& files, std::size_t eye, dsp::Pinhole& lens) {
  YAML::Node node;
  YamlReader& matrix = files.with(kMatrices[eye], node);
  put_matrix(matrix, node, kMatrices[eye].brief, lens);
  YamlReader& distortion = files.with(kDistortions[eye], node);
  put_distortion(distortion, node, kDistortions[eye].brief, lens);
}

int size_of(Files& files, const char* key, int told) {
  return told > 0 ? told : files.integer(key);
}

std::string matrix_text(const char* name, int rows, int columns, const std::vector<double>& data) {
  return printed("%s: !!opencv-matrix\n   rows: %d\n   cols: %d\n   dt: d\n   data: %s\n", name,
                 rows, columns, exact_list(data).c_str());
}

}  // namespace

dataset::Loaded<dsp::RawPair> parse_opencv(const std::vector<NamedText>& texts, int width,
                                           int height) {
  std::vector<YamlReader> readers;
  for (const NamedText& text : texts) {
    dataset::Loaded<YamlReader> reader = YamlReader::of(text);
    if (!reader) {
      return std::unexpected(std::move(reader.error()));
    }
    readers.push_back(std::move(*reader));
  }
  Files all(std::move(readers));
  dsp::RawPair rig;
  put_lens(all, 0, rig.left);
  put_lens(all, 1, rig.right);
  rig.left.width = rig.right.width = size_of(all, "image_width", width);
  rig.left.height = rig.right.height = size_of(all, "image_height", height);
  YAML::Node node;
  YamlReader& turn = all.with({"R", "R"}, node);
  const std::vector<double> r = turn.numbers(node, "R", 9, 9);
  YamlReader& shift = all.with({"T", "T"}, node);
  const std::vector<double> t = shift.numbers(node, "T", 3, 3);
  if (YamlReader* const failed = all.failed()) {
    return std::unexpected(failed->problem());
  }
  if (rig.left.width == 0 || rig.left.height == 0) {
    return dataset::refuse(texts.front().file, "does not say how large the pictures are",
                           "give --size WIDTH HEIGHT");
  }
  for (const dsp::Pinhole& lens : {rig.left, rig.right}) {
    if (width > 0 && !is_centred(lens)) {
      return dataset::refuse(texts.front().file,
                             printed("has a camera with its centre at %.1f, %.1f, outside of the "
                                     "pictures of %dx%d that --size tells",
                                     lens.cx, lens.cy, lens.width, lens.height),
                             "give --size of the pictures that it was made of");
    }
  }
  std::ranges::copy(r, rig.left_to_right.rotation.begin());
  std::ranges::copy(t, rig.left_to_right.translation_m.begin());
  return judged(texts.front().file, rig);
}

std::string opencv_text(const dsp::RawPair& rig) {
  std::string text = printed("%%YAML:1.0\n---\nimage_width: %d\nimage_height: %d\n", rig.left.width,
                             rig.left.height);
  for (const std::size_t eye : {std::size_t{0}, std::size_t{1}}) {
    const dsp::Pinhole& lens = eye == 0 ? rig.left : rig.right;
    text += matrix_text(kMatrices[eye].brief, 3, 3,
                        {lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1});
    text +=
        matrix_text(kDistortions[eye].brief, 1, 5, {lens.k1, lens.k2, lens.p1, lens.p2, lens.k3});
  }
  const dsp::RigidTransform& pose = rig.left_to_right;
  text += matrix_text("R", 3, 3, {pose.rotation.begin(), pose.rotation.end()});
  text += matrix_text("T", 3, 1, {pose.translation_m.begin(), pose.translation_m.end()});
  return text;
}

}  // namespace stof::host
