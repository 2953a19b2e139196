// SPDX-License-Identifier: Apache-2.0
//
// Bad input is refused with a sentence that names the field, its value and the range; good input up
// to its very limits evaluates.
#include "paint.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "batch.h"
#include "flake_brdf.h"
#include "reference/optics.h"
#include "support.h"

namespace {

using namespace metallic_paint;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

template <class Checked>
std::string complaint(const Checked& checked) {
  try {
    validate(checked);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

void expect_names(const std::string& message, const std::vector<std::string>& parts) {
  EXPECT_NE(message, "") << "accepted";
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos)
        << "“" << message << "” lacks “" << part << "”";
  }
}

struct Field {
  std::string name;
  double least, most;
  std::string range;  // as the message words it
  double& (*of)(Paint&);
};

const Field kFields[] = {
    {"flakes_per_mm2", 0, 1e9, "from 0 to 1e+09 1/mm2",
     [](Paint& p) -> double& { return p.flakes_per_mm2; }},
    {"flake_diameter_um", 1e-3, 1e5, "from 0.001 to 100000 um",
     [](Paint& p) -> double& { return p.flake_diameter_um; }},
    {"flake_area_spread", 0, 100, "from 0 to 100",
     [](Paint& p) -> double& { return p.flake_area_spread; }},
    {"tilt", 1e-6, 100, "from 1e-06 to 100 rad (gaussian)",
     [](Paint& p) -> double& { return p.tilt; }},
    {"flake_spread", 0, 0.5, "from 0 to 0.5 rad",
     [](Paint& p) -> double& { return p.flake_spread; }},
    {"flake_color.r", 0, 1, "from 0 to 1", [](Paint& p) -> double& { return p.flake_color.x; }},
    {"flake_color.g", 0, 1, "from 0 to 1", [](Paint& p) -> double& { return p.flake_color.y; }},
    {"flake_color.b", 0, 1, "from 0 to 1", [](Paint& p) -> double& { return p.flake_color.z; }},
    {"flake_edge_color.r", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.flake_edge_color.x; }},
    {"flake_edge_color.g", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.flake_edge_color.y; }},
    {"flake_edge_color.b", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.flake_edge_color.z; }},
    {"flake_transmission.r", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.flake_transmission.x; }},
    {"flake_transmission.g", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.flake_transmission.y; }},
    {"flake_transmission.b", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.flake_transmission.z; }},
    {"binder_ior", 0.1, 10, "from 0.1 to 10", [](Paint& p) -> double& { return p.binder_ior; }},
    {"layer_thickness_um", 0, 1e6, "from 0 to 1000000 um",
     [](Paint& p) -> double& { return p.layer_thickness_um; }},
    {"binder_absorption_per_mm.r", 0, 1e6, "from 0 to 1000000 1/mm",
     [](Paint& p) -> double& { return p.binder_absorption_per_mm.x; }},
    {"binder_absorption_per_mm.g", 0, 1e6, "from 0 to 1000000 1/mm",
     [](Paint& p) -> double& { return p.binder_absorption_per_mm.y; }},
    {"binder_absorption_per_mm.b", 0, 1e6, "from 0 to 1000000 1/mm",
     [](Paint& p) -> double& { return p.binder_absorption_per_mm.z; }},
    {"rayleigh_per_mm", 0, 1e6, "from 0 to 1000000 1/mm",
     [](Paint& p) -> double& { return p.rayleigh_per_mm; }},
    {"sparkle_contrast", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.sparkle_contrast; }},
    {"substrate_color.r", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.substrate_color.x; }},
    {"substrate_color.g", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.substrate_color.y; }},
    {"substrate_color.b", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.substrate_color.z; }},
    {"texture_contrast", 0, 1, "from 0 to 1",
     [](Paint& p) -> double& { return p.texture_contrast; }},
    {"coat_roughness", 0, 1, "from 0 to 1", [](Paint& p) -> double& { return p.coat_roughness; }},
    {"orange_peel", 0, 1, "from 0 to 1 rad", [](Paint& p) -> double& { return p.orange_peel; }},
    {"orange_peel_mm", 1e-3, 1e6, "from 0.001 to 1000000 mm",
     [](Paint& p) -> double& { return p.orange_peel_mm; }},
};

// A paint that any single field may take to its limit: black flakes reflect and transmit nothing.
Paint black_paint() {
  Paint paint;
  paint.flake_color = paint.flake_edge_color = paint.flake_transmission = {0, 0, 0};
  return paint;
}

std::string digits(double value) {
  std::ostringstream text;
  text.precision(9);
  text << value;
  return text.str();
}

TEST(Paint, DefaultIsValid) { EXPECT_EQ(complaint(Paint{}), ""); }

TEST(Paint, EveryFieldIsRefusedOutsideItsRange) {
  for (const Field& field : kFields) {
    for (double value : {field.least - 1e-3 * std::max(1.0, std::fabs(field.least)),
                         std::nextafter(field.least, -kInf), std::nextafter(field.most, kInf),
                         field.most * 1.5 + 1, kInf, -kInf, kNan}) {
      Paint paint = black_paint();
      field.of(paint) = value;
      SCOPED_TRACE(field.name + " = " + digits(value));
      expect_names(complaint(paint), {field.name + " is " + digits(value), field.range});
    }
  }
}

TEST(Paint, RoughnessOfTheFieldsShapesEndsAtOne) {
  for (Orientation kind : {Orientation::beckmann, Orientation::ggx}) {
    for (double tilt : {0.0, 1.0001, 100.0, kNan}) {
      Paint paint;
      paint.orientation = kind;
      paint.tilt = tilt;
      expect_names(complaint(paint), {"tilt is " + digits(tilt), "from 1e-06 to 1 (roughness"});
    }
  }
}

TEST(Paint, UnknownChoicesAreRefused) {
  for (int value : {-1, 3, 1000}) {
    Paint paint;
    paint.orientation = static_cast<Orientation>(value);
    expect_names(complaint(paint), {"orientation is " + digits(value), "2 (ggx)"});
    paint = Paint{};
    paint.depth_model = static_cast<DepthModel>(value);
    expect_names(complaint(paint), {"depth_model is " + digits(value), "0 (attenuated)"});
    paint = Paint{};
    paint.radiometry = static_cast<Radiometry>(value);
    expect_names(complaint(paint), {"radiometry is " + digits(value), "0 (exact)"});
    paint = Paint{};
    paint.composition = static_cast<Composition>(value);
    expect_names(complaint(paint), {"composition is " + digits(value), "0 (exact)"});
  }
}

TEST(Paint, FlakesGiveBackNoMoreThanTheyGet) {
  Paint paint;
  paint.flake_color = {0.9, 0.5, 0.5};
  paint.flake_transmission = {0, 0, 0.6};
  paint.flake_edge_color = {0, 0, 0};
  expect_names(complaint(paint), {"flake_color + flake_transmission is 1.1", "at most 1"});
  paint.flake_color = {0, 0, 0};
  paint.flake_edge_color = {0, 0, 0.5};
  expect_names(complaint(paint), {"flake_edge_color + flake_transmission is 1.1", "at most 1"});
  // 0.9 + 0.1 rounds above 1 in some number types: accepted.
  paint.flake_color = paint.flake_edge_color = {0.9f, 0.7f, 0.3f};
  paint.flake_transmission = {0.1f, 0.3f, 0.7f};
  EXPECT_EQ(complaint(paint), "");
}

template <class T>
void expect_finite(const Paint& paint, const std::string& what) {
  const Layer<T> layer = make_layer<T>(paint);
  const T cosine = T(0.8);
  const SurfacePoint<T> point{{}, {0, 0, 1}, {T(0.6), 0, cosine}, T(1e-8), 3, 4};
  const SeenLight<T> light = see_light<T>({LightKind::parallel, {T(-0.5), 0, T(0.8)}, T(0.01)}, {});
  const auto expected = expect_sparkles(layer, point, light);
  const auto drawn =
      draw_sparkles(expected, layer.flakes[0].area_spread, paint_stream(paint, 0), 3, 4);
  for (T value : {expected.mean_count, mean_radiance(expected).x, mean_radiance(expected).z,
                  radiance_variance(expected).y, drawn.count, drawn.radiance.x,
                  flake_brdf(layer, point.normal, point.view, Vec3<T>(light.direction)).z}) {
    EXPECT_TRUE(std::isfinite(value) && value >= 0)
        << what << ": " << value << (sizeof(T) == 4 ? " in float" : " in double");
  }
}

TEST(Paint, LimitsAreAcceptedAndEvaluate) {
  for (const Field& field : kFields) {
    for (double value : {field.least, field.most}) {
      Paint paint = black_paint();
      field.of(paint) = value;
      const std::string what = field.name + " = " + digits(value);
      EXPECT_EQ(complaint(paint), "") << what;
      expect_finite<double>(paint, what);
      expect_finite<float>(paint, what);
    }
  }
}

TEST(Paint, LimitsOfAllPairsEvaluate) {
  for (const Field& a : kFields) {
    for (const Field& b : kFields) {
      for (int corner = 0; corner < 4; ++corner) {
        Paint paint = black_paint();
        a.of(paint) = corner & 1 ? a.most : a.least;
        b.of(paint) = corner & 2 ? b.most : b.least;
        if (complaint(paint) != "") continue;  // colour and transmission both 1
        const std::string what = a.name + ", " + b.name + ", corner " + std::to_string(corner);
        expect_finite<double>(paint, what);
        expect_finite<float>(paint, what);
      }
    }
  }
}

TEST(Paint, LayerIsInSiUnits) {
  Paint paint;
  paint.flakes_per_mm2 = 1000;
  paint.flake_diameter_um = 20;
  paint.flake_area_spread = 0;
  paint.layer_thickness_um = 40;
  paint.binder_absorption_per_mm = {1, 2, 3};
  paint.rayleigh_per_mm = 0.5;
  const auto layer = make_layer<double>(paint);
  EXPECT_DOUBLE_EQ(layer.flakes[0].areal_density, 1e9);
  EXPECT_NEAR(layer.flakes[0].flake_area, 3.14159265358979e-10, 1e-23);
  EXPECT_NEAR(layer.coverage, 0.314159265358979, 1e-14);
  // H (16 pi/3 c1 + kappa)
  EXPECT_NEAR(layer.binder_depth.y, 0.04 * (16 * 3.14159265358979 / 3 * 0.5 + 2), 1e-13);
}

TEST(Paint, StreamsTellLightsFramesAndSeedsApart) {
  Paint paint, other;
  other.seed = 1;
  EXPECT_NE(paint_stream(paint, 0).x, paint_stream(paint, 1).x);
  EXPECT_NE(paint_stream(paint, 0).x, paint_stream(other, 0).x);
  other = Paint{};
  other.frame = 1;
  EXPECT_NE(paint_stream(paint, 0).x, paint_stream(other, 0).x);
}

TEST(LightInput, BadLightsAreRefused) {
  const auto light = [](LightKind kind, Vec3<double> vector, double size) {
    return complaint(Light<double>{kind, vector, size});
  };
  EXPECT_EQ(light(LightKind::unused, {}, kNan), "");
  EXPECT_EQ(light(LightKind::parallel, {0, 0, 2}, 1), "");
  EXPECT_EQ(light(LightKind::parallel, {0, 0, 2}, 0), "");
  EXPECT_EQ(light(LightKind::positional, {0, 0, 0}, 1e30), "");
  EXPECT_EQ(light(LightKind::positional, {1e30, -1e30, 0}, 0), "");
  expect_names(light(LightKind::parallel, {0, 0, 0}, 0.1), {"light.vector is 0", "above 0"});
  for (double size : {-1e-9, kNan, kInf}) {
    expect_names(light(LightKind::parallel, {0, 0, 1}, size),
                 {"light.size is " + digits(size), "from 0 to 1 "});
    expect_names(light(LightKind::positional, {0, 0, 1}, size),
                 {"light.size is " + digits(size), "from 0 to 1e+30"});
  }
  expect_names(light(LightKind::parallel, {0, 0, 1}, 1.01), {"light.size is 1.01", "to 1 "});
  for (double bad : {kNan, kInf, -kInf, 1.1e30}) {
    expect_names(light(LightKind::parallel, {bad, 0, 0}, 0), {"light.vector.x is", "1e+30"});
    expect_names(light(LightKind::positional, {0, bad, 0}, 0), {"light.vector.y is", "1e+30"});
    expect_names(light(LightKind::positional, {0, 0, bad}, 0), {"light.vector.z is", "1e+30"});
  }
  expect_names(light(static_cast<LightKind>(7), {0, 0, 1}, 0), {"light.kind is 7", "positional"});
}

TEST(PixelInput, BadPixelsAreRefused) {
  std::vector<double> position(9, 0.0), normal{0, 0, 1, 0, 0, 0, 0, 1, 0}, view = normal,
                                                                           footprint{1, 0, 1e30};
  const std::vector<std::int32_t> pixel(6, 0);
  const PixelBatch batch{3,           position.data(),  normal.data(),
                         view.data(), footprint.data(), pixel.data()};
  EXPECT_EQ(complaint(batch), "");
  for (double bad : {kNan, kInf, -1.0}) {
    footprint[1] = bad;
    expect_names(complaint(batch), {"footprint[1] is " + digits(bad), "from 0 to 1e+30 m2"});
  }
  footprint[1] = 0;
  for (double bad : {kNan, 2.0, 0.9}) {
    normal[8] = view[8] = 0;
    normal[7] = bad;
    expect_names(complaint(batch), {"length of normal[2] is", "1 to a thousandth"});
    normal[7] = 1;
    view[0] = 0;
    view[2] = bad;
    expect_names(complaint(batch), {"length of view[0] is", "1 to a thousandth"});
    view[2] = 1;
  }
  position[4] = kNan;
  expect_names(complaint(batch), {"position[1] is nan", "1e+30"});
}

TEST(Paint, DiffractionSpreadsAFlakeAsAnEvenConeOfTheDiscsBrightness) {
  // The references' own derivation; and by hand 12 um in a binder of 1.5: 0.01945 rad.
  for (double diameter : {1e-3, 0.5, 12.0, 34.0, 1e5}) {
    for (double ior : {0.5, 1.0, 1.5, 2.2}) {
      for (double waviness : {0.0, 0.01, 0.5}) {
        Paint paint;
        paint.diffraction = Diffraction::disc;
        paint.flake_diameter_um = diameter;
        paint.binder_ior = ior;
        paint.flake_spread = waviness;
        const double spread = reference::flake_spread(paint, paint);
        EXPECT_NEAR(make_layer<double>(paint).flakes[0].solid_angle,
                    std::numbers::pi * spread * spread, 1e-14)
            << diameter << ' ' << ior << ' ' << waviness;
      }
    }
  }
  EXPECT_NEAR(diffraction_spread(12.0, 1.5), 0.01945, 1e-5);
}

TEST(Paint, ColoursThatACoatingReplacesNeedNotKeepEnergy) {
  Paint paint;
  paint.flake_transmission = {0.5, 0.5, 0.5};
  EXPECT_THROW(validate(paint), std::invalid_argument);
  paint.coating = CoatingKind::aluminium;
  EXPECT_NO_THROW(validate(paint));
}

}  // namespace
