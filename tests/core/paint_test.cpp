// SPDX-License-Identifier: Apache-2.0
//
// Bad input is refused with a sentence that names the field, its value and the range; good input up
// to its very limits evaluates.
#include "paint.h"

#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
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

// A number of the paint, as the table has it (parameters.toml): a channel of a colour is one.
struct Field {
  std::string name;
  double least, most;
  std::string range;  // as the message words it
  std::function<double&(Paint&)> of;
};

std::string digits(double value) {
  std::ostringstream text;
  text.precision(9);
  text << value;
  return text.str();
}

std::vector<Field> all_fields() {
  std::vector<Field> fields;
  const auto add = [&](const char* name, auto member, const auto& range) {
    using Value = std::remove_cvref_t<decltype(std::declval<Paint&>().*member)>;
    if constexpr (std::is_same_v<Value, double>) {
      const std::string worded = "from " + digits(range.least) + " to " + digits(range.most);
      fields.push_back({name, range.least, range.most, worded + range.unit,
                        [member](Paint& paint) -> double& { return paint.*member; }});
    } else if constexpr (std::is_same_v<Value, Rgb<double>>) {
      const std::string worded = "from " + digits(range.least) + " to " + digits(range.most);
      const std::pair<const char*, double Rgb<double>::*> channels[] = {
          {".r", &Rgb<double>::x}, {".g", &Rgb<double>::y}, {".b", &Rgb<double>::z}};
      for (const auto& [letter, channel] : channels) {
        fields.push_back(
            {name + std::string(letter), range.least, range.most, worded + range.unit,
             [member, at = channel](Paint& paint) -> double& { return (paint.*member).*at; }});
      }
    }
  };
  each_flake_parameter(add);
  each_paint_parameter(add);
  return fields;
}

const std::vector<Field> kFields = all_fields();

// A paint that any single field may take to its limit: black flakes reflect and transmit nothing.
Paint black_paint() {
  Paint paint;
  paint.flake_color = paint.flake_edge_color = paint.flake_transmission = {0, 0, 0};
  return paint;
}

TEST(Paint, TheFieldsAreThoseOfTheTable) {
  std::size_t numbers = 0;
  const auto count = [&](const char*, auto member, const auto&) {
    using Value = std::remove_cvref_t<decltype(std::declval<Paint&>().*member)>;
    numbers += std::is_same_v<Value, double> ? 1 : std::is_same_v<Value, Rgb<double>> ? 3 : 0;
  };
  each_flake_parameter(count);
  each_paint_parameter(count);
  EXPECT_EQ(kFields.size(), numbers);
  EXPECT_GE(numbers, 28U);
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
  const auto refused = [](const char* name, auto member, const auto& range) {
    using Value = std::remove_cvref_t<decltype(std::declval<Paint&>().*member)>;
    if constexpr (std::is_enum_v<Value>) {
      std::vector<std::string> words;
      for (std::size_t i = 0; i < range.size(); ++i) {
        words.push_back(std::to_string(i) + " (" + range[i] + ")");
      }
      for (int value : {-1, static_cast<int>(range.size()), 1000}) {
        Paint paint;
        paint.*member = static_cast<Value>(value);
        words.push_back(std::string(name) + " is " + digits(value));
        expect_names(complaint(paint), words);
        words.pop_back();
      }
    }
  };
  each_flake_parameter(refused);
  each_paint_parameter(refused);
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
  // Any two floats that shall add up to 1 are accepted, and no more than the next float above 1.
  for (int i = 0; i <= 100000; ++i) {
    const double share = i / 100000.0;
    const auto rounded = static_cast<float>(share), rest = static_cast<float>(1 - share),
               computed = 1 - rounded;
    EXPECT_LE(static_cast<double>(rounded) + rest, kMostOfASum) << share;
    EXPECT_LE(static_cast<double>(rounded) + computed, kMostOfASum) << share;
  }
  EXPECT_EQ(kMostOfASum, std::nextafter(1.0f, 2.0f));
  paint.flake_transmission = {0.3, 0.3, 0.3};
  paint.flake_edge_color = {0.7, 0.7, 0.7};
  paint.flake_color = {0.7000001, 0.7, 0.7};
  EXPECT_EQ(complaint(paint), "");
  paint.flake_color = {0.7, 0.7000002, 0.7};
  expect_names(complaint(paint), {"flake_color + flake_transmission is 1.0000002, but must be at"});
}

TEST(Paint, TheFilmIsAsThickAsTheLibraryHasIt) {
  each_flake_parameter([](const std::string& name, auto, const auto& range) {
    if constexpr (requires { range.most; }) {
      if (name == "coating_nm") {
        EXPECT_EQ(range.most, kMostCoatingNm);
      }
    }
  });
}

template <class T>
void expect_finite(const Paint& paint, const std::string& what) {
  const Layer<T> layer = make_layer<T>(paint);
  const T cosine = T(0.8);
  const SurfacePoint<T> point{{}, {0, 0, 1}, {T(0.6), 0, cosine}, T(1e-8), 3, 4};
  const SeenLight<T> light = see_light<T>({LightKind::parallel, {T(-0.5), 0, T(0.8)}, T(0.01)}, {});
  const auto expected = expect_sparkles(layer, point, light);
  const auto drawn = draw_sparkles(expected, stream_key(0, 0, paint.frame, paint.seed));
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
  const PixelBatch batch{3,
                         position.data(),
                         normal.data(),
                         view.data(),
                         footprint.data(),
                         pixel.data(),
                         position.data()};
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
