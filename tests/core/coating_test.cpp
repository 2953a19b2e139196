// SPDX-License-Identifier: Apache-2.0
//
// The coating library: the core's reading of it against the references', and the few flakes that
// stand for all in the optical depth.
#include "coating.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "optical_thickness.h"
#include "reference/flake_normals.h"
#include "reference/optics.h"
#include "reference/transmitted_area.h"
#include "support.h"
#include "validation.h"

namespace {

using namespace metallic_paint;
using core_tests::Random;
using core_tests::same_scenes;
using core_tests::Worst;

template <class T>
Coating<T> library_coating(int kind, double nm) {
  Coating<T> coating{};
  coating.kind = static_cast<CoatingKind>(kind);
  coating.thickness_nm = static_cast<T>(nm);
  return coating;
}

double largest(Rgb<double> difference) {
  return std::max({std::fabs(difference.x), std::fabs(difference.y), std::fabs(difference.z)});
}

template <class Visit>
void at_random_places(const Visit& visit) {
  Random random = same_scenes(5);
  for (int kind = 1; kind < kCoatingKinds; ++kind) {
    for (int i = 0; i < 4000; ++i) {
      const double nm = random.uniform(0, 200);
      visit(kind, nm, random.uniform());
    }
    for (double nm : {0.0, 5.0, 195.0, 200.0}) {
      for (double cosine : {0.0, 0.5, 2.0 / 3, 1.0}) visit(kind, nm, cosine);
    }
  }
}

TEST(CoatingLibrary, HoldsWhatItsLayoutNeeds) {
  EXPECT_EQ(std::size(kCoatingLibrary),
            3 * kCoatingNodes * (kFirstPearl - 1 + (kPearls + 2) * kCoatingRows));
}

TEST(CoatingLibrary, IsReadAsTheReferenceReadsIt) {
  Worst in_double, in_float;
  at_random_places([&](int kind, double nm, double cosine) {
    const auto which = static_cast<CoatingKind>(kind);
    const Rgb<double> r = reference::library_reflectance(which, nm, cosine);
    const Rgb<double> t = reference::library_transmittance(which, nm, cosine);
    const auto coating = library_coating<double>(kind, nm);
    in_double.see(largest(coating_reflectance(coating, cosine) - r), "kind", kind, "nm", nm, "cos",
                  cosine);
    in_double.see(largest(coating_transmittance(coating, cosine) - t), "kind", kind, "nm", nm,
                  "cos", cosine);
    const auto narrow = library_coating<float>(kind, nm);
    const auto c = static_cast<float>(cosine);
    in_float.see(largest(Rgb<double>(coating_reflectance(narrow, c)) - r), "kind", kind, "nm", nm,
                 "cos", cosine);
    in_float.see(largest(Rgb<double>(coating_transmittance(narrow, c)) - t), "kind", kind, "nm", nm,
                 "cos", cosine);
  });
  in_double.expect_at_most(1e-14, "double");
  in_float.expect_at_most(2e-5, "float");  // places rounded to 2^-22, slopes up to 24 and more
}

TEST(CoatingLibrary, GivesBackNoMoreThanFallsIn) {
  at_random_places([](int kind, double nm, double cosine) {
    const auto coating = library_coating<float>(kind, nm);
    const auto c = static_cast<float>(cosine);
    const Rgb<float> r = coating_reflectance(coating, c), t = coating_transmittance(coating, c);
    for (const auto& [one_r, one_t] : {std::pair{r.x, t.x}, {r.y, t.y}, {r.z, t.z}}) {
      ASSERT_GE(one_r, 0) << "kind " << kind << " nm " << nm << " cos " << cosine;
      ASSERT_GE(one_t, 0) << "kind " << kind << " nm " << nm << " cos " << cosine;
      ASSERT_LE(one_r + one_t, 1 + 1e-6F) << "kind " << kind << " nm " << nm << " cos " << cosine;
    }
  });
}

TEST(CoatingLibrary, KnowsNoMoreThanItsEnds) {
  const auto coating = library_coating<float>(9, 1e9), end = library_coating<float>(9, 200);
  EXPECT_EQ(coating_reflectance(coating, 0.8F).x, coating_reflectance(end, 0.8F).x);
  EXPECT_EQ(coating_reflectance(end, 1.0001F).y, coating_reflectance(end, 1.0F).y);
  EXPECT_EQ(coating_reflectance(end, -0.1F).z, coating_reflectance(end, 0.0F).z);
  // A metal has no thickness.
  EXPECT_EQ(coating_reflectance(library_coating<float>(3, 77), 0.8F).x,
            coating_reflectance(library_coating<float>(3, 0), 0.8F).x);
}

TEST(CoatingLibrary, MetalsBlockAllTheirArea) {
  const auto density = make_orientation<double>(Orientation::gaussian, 0.2);
  for (int kind : {1, 8, static_cast<int>(CoatingKind::fe2o3_on_aluminium)}) {
    const Rgb<double> blocked =
        blocked_area<double>(density, library_coating<double>(kind, 60), 0.8);
    EXPECT_EQ(blocked.y, mean_projected_area(density, 0.8)) << "kind " << kind;
  }
}

// Against the double integral over all flakes; what optical_thickness.h states.
TEST(CoatingLibrary, LongFourFlakesStandForAll) {
  Worst mica[3], silica[3];
  for (int kind = kFirstPearl; kind < kCoatingKinds; ++kind) {
    const auto which = static_cast<CoatingKind>(kind);
    if (!is_clear(which)) continue;
    const bool on_mica = which == CoatingKind::tio2_on_mica || which == CoatingKind::fe2o3_on_mica;
    for (Orientation shape : {Orientation::gaussian, Orientation::beckmann, Orientation::ggx}) {
      for (double tilt : {0.02, 0.05, 0.1, 0.15, 0.2, 0.35, 0.5}) {
        const auto density = make_orientation<double>(shape, tilt);
        for (double nm : {10.0, 30.0, 50.0, 80.0, 120.0, 150.0, 190.0}) {
          const auto coating = library_coating<double>(kind, nm);
          for (double cosine : {0.05, 0.2, 0.4, 0.6, 0.7, 0.745, 0.8, 0.87, 0.93, 1.0}) {
            const Rgb<double> exact = grey(mean_projected_area(density, cosine)) -
                                      reference::mean_transmitted_area(density, coating, cosine);
            const Rgb<double> ours = blocked_area<double>(density, coating, cosine);
            const int range = cosine < 0.7 ? 2 : tilt > 0.2 ? 1 : 0;
            (on_mica ? mica : silica)[range].see(largest(ours - exact), "kind", kind, "shape",
                                                 static_cast<int>(shape), "tilt", tilt, "nm", nm,
                                                 "cos", cosine);
          }
        }
      }
    }
  }
  const char* const names[] = {"tilt_to_0.2", "tilt_to_0.5", "below_0.7"};
  const double on_mica[] = {0.008, 0.03, 0.025}, on_silica[] = {0.04, 0.1, 0.11};
  for (int range = 0; range < 3; ++range) {
    mica[range].expect_at_most(on_mica[range], std::string("mica_") + names[range]);
    silica[range].expect_at_most(on_silica[range], std::string("silica_") + names[range]);
  }
}

TEST(CoatingLibrary, ReferencesLetThroughWhatTheDoubleIntegralDoes) {
  Worst worst;
  for (Orientation shape : {Orientation::gaussian, Orientation::beckmann, Orientation::ggx}) {
    for (double tilt : {0.05, 0.3}) {
      const auto density = make_orientation<double>(shape, tilt);
      const reference::FlakeNormals normals(shape, tilt);
      for (int kind : {9, 10, 13}) {
        const auto which = static_cast<CoatingKind>(kind);
        for (double cosine : {0.3, 0.75, 1.0}) {
          const Rgb<double> ours = normals.transmitted_area(
              cosine, [&](double c) { return reference::library_transmittance(which, 77, c); });
          const Rgb<double> exact =
              reference::mean_transmitted_area(density, library_coating<double>(kind, 77), cosine);
          worst.see(largest(ours - exact), "shape", static_cast<int>(shape), "tilt", tilt, "kind",
                    kind, "cos", cosine);
        }
      }
    }
  }
  worst.expect_at_most(1e-4);
}

TEST(CoatingLibrary, FlatFlakesTransmitAtTheAngleOfTheRay) {
  const auto density = make_orientation<double>(Orientation::gaussian, 1e-4);
  for (int kind : {9, 10, 13}) {
    const auto coating = library_coating<double>(kind, 62);
    for (double cosine : {0.3, 0.8, 1.0}) {
      const Rgb<double> passed = mean_flake_transmittance(density, coating, cosine);
      EXPECT_LT(largest(passed - coating_transmittance(coating, cosine)), 1e-3) << cosine;
    }
  }
}

TEST(CoatingLibrary, AnyTiltAndRayStayFinite) {
  for (Orientation shape : {Orientation::gaussian, Orientation::beckmann, Orientation::ggx}) {
    for (float tilt : {1e-6F, 0.3F, 1.0F}) {
      const auto density = make_orientation<float>(shape, tilt);
      for (float cosine : {0.0F, 1e-4F, 0.5F, 1.0F}) {
        const Rgb<float> passed =
            mean_flake_transmittance(density, library_coating<float>(13, 30), cosine);
        ASSERT_TRUE(passed.x >= 0 && passed.x <= 1 && passed.z >= 0 && passed.z <= 1)
            << "tilt " << tilt << " cos " << cosine;
      }
    }
  }
}

std::string complaint(int kind, double nm) {
  try {
    require_library_coating("coating", kind, nm);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

TEST(CoatingLibrary, BadCoatingsAreNamed) {
  EXPECT_EQ(complaint(0, 0),
            "coating is 0, but must be from 1 (aluminium) to 14 (fe2o3-on-aluminium).");
  EXPECT_EQ(complaint(1, 0), "");
  EXPECT_EQ(complaint(14, 200), "");
  EXPECT_EQ(complaint(15, 0),
            "coating is 15, but must be from 1 (aluminium) to 14 "
            "(fe2o3-on-aluminium).");
  EXPECT_EQ(complaint(-1, 0).find("coating is -1"), 0U);
  EXPECT_EQ(complaint(9, 201), "coating_nm is 201, but must be from 0 to 200 nm.");
  EXPECT_EQ(complaint(9, std::nan("")).find("coating_nm is nan"), 0U);
}

}  // namespace
