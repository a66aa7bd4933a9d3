#include "host/calibrate/rig/exchange/exchange.h"

#include <string>
#include <tuple>
#include <utility>

#include <gtest/gtest.h>

#include "tests/host/calibrate/rig/board_views.h"

namespace stof::host {
namespace {

// As the documentation of each format shows a file of it: names, order and layout.
constexpr const char* kRosLeft = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/left
camera_matrix:
  rows: 3
  cols: 3
  data: [438.783367, 0.000000, 305.593336, 0.000000, 437.302876, 243.738352, 0.000000, 0.000000, 1.000000]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.361976, 0.110510, 0.001014, 0.000505, 0.000000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0.999978, 0.002789, -0.006046, -0.002816, 0.999986, -0.004401, 0.006034, 0.004417, 0.999972]
projection_matrix:
  rows: 3
  cols: 4
  data: [393.653800, 0.000000, 322.797939, 0.000000, 0.000000, 393.653800, 241.090902, 0.000000, 0.000000, 0.000000, 1.000000, 0.000000]
)";
constexpr const char* kRosRight = R"(image_width: 640
image_height: 480
camera_name: narrow_stereo/right
camera_matrix:
  rows: 3
  cols: 3
  data: [436.5, 0.0, 310.1, 0.0, 435.9, 240.2, 0.0, 0.0, 1.0]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.35, 0.1, 0.0, 0.0, 0.0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
projection_matrix:
  rows: 3
  cols: 4
  data: [393.653800, 0.0, 322.797939, -47.238456, 0.0, 393.653800, 241.090902, 0.0, 0.0, 0.0, 1.0, 0.0]
)";
constexpr const char* kKalibr = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.27695497, 0.06712482, 0.00087538, 0.00011556]
  distortion_model: radtan
  intrinsics: [461.629, 460.152, 362.680, 246.049]
  resolution: [752, 480]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.999989, -0.002312, 0.004123, -0.110074]
  - [0.002317, 0.999997, -0.001216, 0.000399]
  - [-0.004120, 0.001226, 0.999991, -0.000854]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0001, -0.0002]
  distortion_model: radtan
  intrinsics: [459.1, 457.9, 375.1, 252.0]
  resolution: [752, 480]
  rostopic: /cam1/image_raw
)";
// As camera_calibration's ost.txt: both cameras in one file.
constexpr const char* kIni = R"(# oST version 5.0 parameters


[image]

width
640

height
480

[narrow_stereo/left]

camera matrix
438.783367 0.000000 305.593336
0.000000 437.302876 243.738352
0.000000 0.000000 1.000000

distortion
-0.361976 0.110510 0.001014 0.000505 0.000000

rectification
0.999978 0.002789 -0.006046
-0.002816 0.999986 -0.004401
0.006034 0.004417 0.999972

projection
393.653800 0.000000 322.797939 0.000000
0.000000 393.653800 241.090902 0.000000
0.000000 0.000000 1.000000 0.000000

[externals]

translation
0 0 0

[narrow_stereo/right]

camera matrix
436.5 0.0 310.1
0.0 435.9 240.2
0.0 0.0 1.0

distortion
-0.35 0.1 0.0 0.0 0.0

rectification
1.0 0.0 0.0
0.0 1.0 0.0
0.0 0.0 1.0

projection
393.653800 0.0 322.797939 -47.238456
0.0 393.653800 241.090902 0.0
0.0 0.0 1.0 0.0
)";
// As FileStorage writes JSON.
constexpr const char* kJson = R"({
    "image_width": 640,
    "image_height": 480,
    "cameraMatrix1": {
        "type_id": "opencv-matrix",
        "rows": 3,
        "cols": 3,
        "dt": "d",
        "data": [ 534.8, 0.0, 334.23, 0.0, 534.8, 241.44, 0.0,
            0.0, 1.0 ]
    },
    "distCoeffs1": {
        "type_id": "opencv-matrix", "rows": 1, "cols": 5, "dt": "d",
        "data": [ -2.8e-01, 4.8e-02, 1.2e-03, -1.2e-03, 1.9e-01 ]
    },
    "cameraMatrix2":{"type_id":"opencv-matrix","rows":3,"cols":3,"dt":"d","data":[534.8,0,334.32,0,534.8,242.15,0,0,1]},
    "distCoeffs2": {
        "type_id": "opencv-matrix", "rows": 1, "cols": 4, "dt": "d",
        "data": [ -2.8e-01, 1.0e-01, 0.0, 0.0 ]
    },
    "R": {
        "type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d",
        "data": [ 0.99999, 0.0042, -0.0013, -0.0042, 0.99998, -0.0036, 0.0013, 0.0036, 0.99999 ]
    },
    "T": {
        "type_id": "opencv-matrix", "rows": 3, "cols": 1, "dt": "d",
        "data": [ -0.0334, 0.0004, -0.0002 ]
    }
}
)";
constexpr const char* kIntrinsics = R"(%YAML:1.0
---
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3480e+02, 0., 3.3423e+02, 0., 5.3480e+02, 2.4144e+02, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -2.8e-01, 4.8e-02, 1.2e-03,
       -1.2e-03, 1.9e-01 ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3480e+02, 0., 3.3432e+02, 0., 5.3480e+02, 2.4215e+02, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 8
   dt: d
   data: [ -2.8e-01, 1.0e-01, 0., 0., 0., 0., 0., 0. ]
)";
constexpr const char* kExtrinsics = R"(%YAML:1.0
---
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0.99999, 0.0042, -0.0013, -0.0042, 0.99998, -0.0036, 0.0013, 0.0036, 0.99999 ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.0334, 0.0004, -0.0002 ]
)";

NamedText named(const char* name, const std::string& text) { return {name, text}; }

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

void expect_equal(const dsp::Pinhole& a, const dsp::Pinhole& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  const LensUnknowns x = unknowns_of(a);
  const LensUnknowns y = unknowns_of(b);
  for (std::size_t i = 0; i < kLensUnknowns; ++i) {
    EXPECT_NEAR(x[i], y[i], 1e-9) << kLensNames[i];
  }
}

void expect_equal(const dsp::RawPair& a, const dsp::RawPair& b) {
  expect_equal(a.left, b.left);
  expect_equal(a.right, b.right);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_NEAR(a.left_to_right.rotation[i], b.left_to_right.rotation[i], 1e-9);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(a.left_to_right.translation_m[i], b.left_to_right.translation_m[i], 1e-9);
  }
}

TEST(Exchange, KalibrsExampleIsRead) {
  const dataset::Loaded<dsp::RawPair> rig = parse_kalibr(named("camchain.yaml", kKalibr));
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->left.width, 752);
  EXPECT_EQ(rig->left.fy, 460.152);
  EXPECT_EQ(rig->left.p1, 0.00087538);
  EXPECT_EQ(rig->left_to_right.translation_m[0], -0.110074);
  EXPECT_EQ(rig->left_to_right.rotation[1], -0.002312);
}

TEST(Exchange, RosExampleIsRead) {
  const dataset::Loaded<dsp::RawPair> rig =
      parse_ros({named("left.yaml", kRosLeft), named("right.yaml", kRosRight)});
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->left.k1, -0.361976);
  EXPECT_EQ(rig->right.cx, 310.1);
  EXPECT_NEAR(rig->left_to_right.translation_m[0], -0.12, 1e-9);
  EXPECT_EQ(rig->left_to_right.rotation[2], -0.006046) << "R of the right one is the identity";
}

TEST(Exchange, OpenCvsExampleIsRead) {
  const NamedText intrinsics = named("intrinsics.yml", kIntrinsics);
  const NamedText extrinsics = named("extrinsics.yml", kExtrinsics);
  const dataset::Loaded<dsp::RawPair> rig = parse_opencv({intrinsics, extrinsics}, 640, 480);
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->left.k3, 0.19);
  EXPECT_EQ(rig->left.p2, -0.0012);
  EXPECT_EQ(rig->right.cy, 242.15);
  EXPECT_EQ(rig->left_to_right.translation_m[0], -0.0334);
  const dataset::Loaded<dsp::RawPair> unsized_rig = parse_opencv({intrinsics, extrinsics}, 0, 0);
  ASSERT_FALSE(unsized_rig);
  EXPECT_NE(unsized_rig.error().message.find("--size"), std::string::npos);
}

TEST(Exchange, AnIniFileIsReadAsItsYaml) {
  const dataset::Loaded<dsp::RawPair> yaml =
      parse_ros({named("left.yaml", kRosLeft), named("right.yaml", kRosRight)});
  const dataset::Loaded<dsp::RawPair> ini = parse_ros({named("ost.txt", kIni)});
  ASSERT_TRUE(yaml && ini) << ini.error().message;
  expect_equal(*ini, *yaml);
  const std::string text = kIni;
  const std::size_t right = text.find("[narrow_stereo/right]");
  const std::string size = "[image]\nwidth\n640\nheight\n480\n";
  const dataset::Loaded<dsp::RawPair> two = parse_ros(
      {named("left.ini", text.substr(0, right)), named("right.ini", size + text.substr(right))});
  ASSERT_TRUE(two) << two.error().message;
  expect_equal(*two, *yaml);
}

TEST(Exchange, OpenCvsJsonIsRead) {
  const dataset::Loaded<dsp::RawPair> rig = parse_opencv({named("rig.json", kJson)}, 0, 0);
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_EQ(rig->left.width, 640);
  EXPECT_EQ(rig->left.k3, 0.19);
  EXPECT_EQ(rig->right.cy, 242.15);
  EXPECT_EQ(rig->right.k3, 0);
  EXPECT_EQ(rig->left_to_right.translation_m[0], -0.0334);
}

std::string message(const dataset::Loaded<dsp::RawPair>& rig) {
  return rig ? std::string("taken") : rig.error().message;
}

// Each says which line of the file, and what of it.
TEST(Exchange, WrongIniFilesAreRefusedWithTheLine) {
  const auto says = [](std::string_view what, std::string_view with) {
    return message(parse_ros({named("ost.txt", replaced(kIni, what, with))}));
  };
  for (const auto& [what, with, expected] :
       {std::tuple("width\n640", "width\n", "line 12: has no width and height"),
        std::tuple("width\n640", "width\n64x", "line 7: has what is no number"),
        std::tuple("width\n640", "width\n0", "line 7: has a width or height"),
        std::tuple("width", "depth", "line 6: has in [image] what is neither"),
        std::tuple("640", "640 480", "line 7: has numbers without a name"),
        std::tuple("[image]", "width", "is no YAML"),
        std::tuple("[narrow_stereo/left]", "[narrow_stereo/left", "line 12: has a section"),
        std::tuple("distortion", "distortions", "line 19: has what is no name"),
        std::tuple("0.110510", "nan", "line 20: has what is no number"),
        std::tuple("0.110510", "0.1 0 0 0 0.3", "line 19: has a rational model (coefficient 6"),
        std::tuple("rectification", "distortion", "line 22: has distortion more than once"),
        std::tuple("0.000000 437.302876", "0.1 437.302876",
                   "line 14: has a camera matrix with skew"),
        std::tuple("0.000000 437.302876", "437.302876", "line 14: has 8 numbers of camera matrix"),
        std::tuple("0.006034", "0.006034 1", "line 25: has too many numbers"),
        std::tuple("393.653800", "-393.653800",
                   "line 27: has a projection matrix without a focal")}) {
    const std::string said = says(what, with);
    EXPECT_NE(said.find(expected), std::string::npos) << with << ": " << said;
  }
  const std::string text = kIni;
  EXPECT_NE(message(parse_ros({named("ost.txt", text.substr(0, text.find("[externals]")))}))
                .find("makes 1 cameras in all"),
            std::string::npos);
}

TEST(Exchange, WrongYamlAndJsonAreRefusedWithTheLine) {
  const auto kalibr = [](std::string_view what, std::string_view with) {
    return message(parse_kalibr(named("c.yaml", replaced(kKalibr, what, with))));
  };
  const auto opencv = [](std::string_view what, std::string_view with) {
    return message(parse_opencv({named("r.json", replaced(kJson, what, with))}, 0, 0));
  };
  for (const auto& [said, expected] :
       {std::pair(kalibr("intrinsics", "intrinsic"), "line 2: has no intrinsics"),
        std::pair(kalibr("461.629", "461,5, 3"), "line 6: has 6 numbers in intrinsics"),
        std::pair(kalibr("461.629", "f"), "line 6: has in intrinsics what is no number"),
        std::pair(kalibr("[752, 480]", "752"), "line 7: has a resolution"),
        std::pair(kalibr("  rostopic", "  camera_model: omni\n  rostopic"),
                  "line 3: has camera_model more than once"),
        std::pair(kalibr("pinhole", "\"pin\\nhole\""),
                  "line 3: has a camera model that is no word"),
        std::pair(kalibr("  - [0.0, 0.0, 0.0, 1.0]\n", ""),
                  "line 11: has a T_cn_cnm1 that is no 4"),
        std::pair(opencv("\"rows\": 3", "\"rows\": 2"), "line 4: has 9 numbers in M1, not 2 rows"),
        std::pair(opencv("241.44", "null"), "line 9: has in M1 what is no number"),
        std::pair(opencv("\"T\"", "\"t\""), "has no T"),
        std::pair(opencv("{\n    \"image", "<?xml?>\n    \"image"), "line 1: is XML"),
        std::pair(opencv("\"image_width\"", "\"image_width"), "is no YAML")}) {
    EXPECT_NE(said.find(expected), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  }
}

// The pose between the eyes is in R and P of both: they have to belong together.
TEST(Exchange, RectificationsThatContradictEachOtherAreRefused) {
  const auto says = [](std::string_view what, std::string_view with, bool of_left = false) {
    return message(
        parse_ros({named("left.yaml", of_left ? replaced(kRosLeft, what, with) : kRosLeft),
                   named("right.yaml", of_left ? kRosRight : replaced(kRosRight, what, with))}));
  };
  EXPECT_EQ(says("393.653800", "393.653800"), "taken");
  EXPECT_NE(says("[393.653800", "[300.0")
                .find("right.yaml: line 18: has a projection matrix with focal lengths of 300 and "
                      "393.654 px, which are 393.654 and 393.654 in left.yaml"),
            std::string::npos)
      << says("[393.653800", "[300.0");
  EXPECT_NE(says("241.090902", "251.0")
                .find("right.yaml: line 18: has a projection matrix whose "
                      "centre is in row 251"),
            std::string::npos)
      << says("241.090902", "251.0");
  const std::string both = message(parse_ros({named("ost.txt", [] {
    std::string text = kIni;
    const std::size_t right = text.rfind("393.653800");
    return text.replace(right, 10, "300.000000");
  }())}));
  EXPECT_NE(both.find("focal lengths of"), std::string::npos) << both;
  // What is wrong with the left file is told of the left file.
  EXPECT_NE(says("438.783367", "-438.783367", true).find("left.yaml: line 5: a raw camera has"),
            std::string::npos)
      << says("438.783367", "-438.783367", true);
  EXPECT_NE(
      says("0.999978", "0.799978", true).find("left.yaml: line 14: has a rectification matrix"),
      std::string::npos)
      << says("0.999978", "0.799978", true);
}

TEST(Exchange, CentresOutsideOfThePictureAreRefused) {
  const auto opencv = [](int width, int height) {
    return message(
        parse_opencv({named("i.yml", kIntrinsics), named("e.yml", kExtrinsics)}, width, height));
  };
  EXPECT_EQ(opencv(640, 480), "taken");
  for (const auto& [width, height] : {std::pair(320, 240), std::pair(2, 2)}) {
    EXPECT_NE(opencv(width, height).find("give --size of the pictures that it was made of"),
              std::string::npos)
        << opencv(width, height);
  }
  const std::string kalibr =
      message(parse_kalibr(named("c.yaml", replaced(replaced(kKalibr, "[752, 480]", "[320, 240]"),
                                                    "[752, 480]", "[320, 240]"))));
  EXPECT_NE(kalibr.find("centre at 362.7, 246.0, outside of the picture of 320x240"),
            std::string::npos)
      << kalibr;
}

TEST(Exchange, WhatAFormatDoesNotHaveIsRefused) {
  EXPECT_NE(
      message(parse_kalibr(named("c.yaml", replaced(kKalibr, "0.00011556]", "0.00011556, 0.01]"))))
          .find("line 4: has 5 distortion_coeffs"),
      std::string::npos);
  EXPECT_NE(message(parse_kalibr(named("c.yaml", std::string(kKalibr) + "cam2:\n  a: 1\n")))
                .find("has a third camera"),
            std::string::npos);
  const std::string twice = message(
      parse_opencv({named("i.yml", kIntrinsics), named("again.yml", kIntrinsics)}, 640, 480));
  EXPECT_NE(twice.find("again.yml: line "), std::string::npos) << twice;
  EXPECT_NE(twice.find("has M1, which is there twice"), std::string::npos) << twice;
}

TEST(Exchange, EveryFormatGivesBackWhatItWasGiven) {
  dsp::RawPair rig = test::true_pair();
  const dataset::Loaded<std::string> kalibr = kalibr_text(rig);
  ASSERT_TRUE(kalibr);
  const dataset::Loaded<dsp::RawPair> by_kalibr = parse_kalibr(named("chain.yaml", *kalibr));
  ASSERT_TRUE(by_kalibr) << by_kalibr.error().message;
  expect_equal(*by_kalibr, rig);
  rig.left.k3 = 0.0123;
  EXPECT_FALSE(kalibr_text(rig)) << "Kalibr has no k3";
  const dataset::Loaded<dsp::RawPair> by_opencv =
      parse_opencv({named("rig.yml", opencv_text(rig))}, 0, 0);
  ASSERT_TRUE(by_opencv) << by_opencv.error().message;
  expect_equal(*by_opencv, rig);
  const dataset::Loaded<dsp::RawPair> by_ros =
      parse_ros({named("l.yaml", ros_text(rig, false)), named("r.yaml", ros_text(rig, true))});
  ASSERT_TRUE(by_ros) << by_ros.error().message;
  expect_equal(*by_ros, rig);
}

TEST(Exchange, ModelsThatRectificationDoesNotKnowAreRefusedByNameAndLine) {
  const auto kalibr_says = [](std::string_view what, std::string_view with) {
    const dataset::Loaded<dsp::RawPair> rig =
        parse_kalibr(named("c.yaml", replaced(kKalibr, what, with)));
    return rig ? std::string("taken") : rig.error().message;
  };
  EXPECT_NE(
      kalibr_says("radtan", "equidistant").find("line 5: has the distortion model equidistant"),
      std::string::npos);
  EXPECT_NE(kalibr_says("pinhole", "omni").find("line 3: has the camera model omni"),
            std::string::npos);
  const dataset::Loaded<dsp::RawPair> rational =
      parse_ros({named("left.yaml", replaced(kRosLeft, "plumb_bob", "rational_polynomial")),
                 named("right.yaml", kRosRight)});
  ASSERT_FALSE(rational);
  EXPECT_NE(rational.error().message.find("line 8: has the distortion model rational_polynomial"),
            std::string::npos)
      << rational.error().message;
  const dataset::Loaded<dsp::RawPair> eight = parse_opencv(
      {named("i.yml",
             replaced(kIntrinsics, "0., 0., 0., 0., 0., 0. ]", "0., 0., 0., 0.3, 0., 0. ]")),
       named("e.yml", kExtrinsics)},
      640, 480);
  ASSERT_FALSE(eight);
  EXPECT_NE(eight.error().message.find("rational"), std::string::npos) << eight.error().message;
  EXPECT_NE(eight.error().message.find("line 1"), std::string::npos) << eight.error().message;
}

TEST(Exchange, DamagedFilesAreRefusedInOneLine) {
  const std::string whole(kKalibr);
  const std::size_t last = whole.rfind("intrinsics");
  for (std::size_t length = 0; length < last; length += 7) {
    const dataset::Loaded<dsp::RawPair> rig =
        parse_kalibr(named("cut.yaml", whole.substr(0, length)));
    ASSERT_FALSE(rig) << length;
    EXPECT_EQ(rig.error().message.find('\n'), std::string::npos);
  }
  for (const char* const text : {"", "[1, 2]", "cam0: 3", "cam0: [", "\t", "cam0: {intrinsics: {}}",
                                 "a: &a [*a]", "%YAML:1.0", "cam0:\n  camera_model: [pinhole]\n"}) {
    EXPECT_FALSE(parse_kalibr(named("bad.yaml", text))) << text;
    EXPECT_FALSE(parse_opencv({named("bad.yaml", text)}, 640, 480)) << text;
    EXPECT_FALSE(parse_ros({named("bad.yaml", text), named("bad.yaml", text)})) << text;
  }
  EXPECT_FALSE(parse_kalibr(named("deep.yaml", std::string(100000, '['))));
  EXPECT_FALSE(parse_kalibr(named("nan.yaml", replaced(kKalibr, "461.629", ".nan"))));
  EXPECT_FALSE(parse_kalibr(named("mirror.yaml", replaced(kKalibr, "0.999989", "-0.999989"))));
}

}  // namespace
}  // namespace stof::host
