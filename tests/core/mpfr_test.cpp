// SPDX-License-Identifier: Apache-2.0
//
// Rounding, in units of the last place, of double and float against MPFR with 160 bits, where the
// formulas can be written as they stand. The paint's numbers and the vectors' components are taken
// as given, to the last bit.
#include <mpreal.h>

#include <functional>
#include <vector>

#include "scenes.h"
#include "support.h"

namespace {

using namespace core_tests;
using mpfr::mpreal;

constexpr int kBits = 160;

mpreal pi() { return mpfr::const_pi(kBits); }

class Mpfr : public testing::Test {
 protected:
  static void SetUpTestSuite() { mpreal::set_default_prec(kBits); }
};

// Error in units of the last place of T; 0 where T holds no normal number of that size.
template <class T>
long double ulps_off(T value, const mpreal& exact) {
  if (abs(exact) < std::numeric_limits<T>::min()) return 0;
  const mpreal scale =
      pow(mpreal(2), floor(log2(abs(exact))) - (std::numeric_limits<T>::digits - 1));
  return (abs(mpreal(value) - exact) / scale).toLDouble();
}

long double relative(double value, const mpreal& exact) {
  return (abs(mpreal(value) - exact) / abs(exact)).toLDouble();
}

// tanh-sinh quadrature with a step that leaves 1e-25 of what is integrated here.
struct Node {
  mpreal weight, gap;  // of an interval of half-width 1; from the nearer end, without cancellation
  bool near_from;
};
const std::vector<Node>& nodes() {
  static const std::vector<Node> all = [] {
    std::vector<Node> made;
    const mpreal step = mpreal(1) / 24;
    for (int i = -105; i <= 105; ++i) {
      const mpreal u = pi() / 2 * sinh(step * i);
      const mpreal weight = step * pi() / 2 * cosh(step * i) / (cosh(u) * cosh(u));
      made.push_back({weight, 2 / (1 + exp(2 * abs(u))), i < 0});
    }
    return made;
  }();
  return all;
}

mpreal integrate(const std::function<mpreal(const mpreal&)>& f, const mpreal& from,
                 const mpreal& to) {
  const mpreal half = (to - from) / 2;
  mpreal sum = 0;
  for (const Node& node : nodes()) {
    const mpreal gap = half * node.gap;
    sum += node.weight * f(node.near_from ? from + gap : to - gap);
  }
  return sum * half;
}

mpreal integrate(const std::function<mpreal(const mpreal&)>& f, const std::vector<mpreal>& edges) {
  mpreal sum = 0;
  for (std::size_t i = 1; i < edges.size(); ++i) sum += integrate(f, edges[i - 1], edges[i]);
  return sum;
}

mpreal shape(const Paint& paint, const mpreal& beta) {
  const mpreal t2 = mpreal(paint.tilt) * paint.tilt, s = sin(beta), c = cos(beta);
  if (paint.orientation == Orientation::gaussian) return exp(-beta * beta / (2 * t2));
  if (paint.orientation == Orientation::beckmann) {
    return exp(-(s * s) / (c * c * t2)) / (c * c * c * c);
  }
  const mpreal d = t2 * c * c + s * s;
  return 1 / (d * d);
}

// Ends of pieces that grow with beta, between the given angles.
std::vector<mpreal> pieces(const Paint& paint, const mpreal& from, const mpreal& to) {
  std::vector<mpreal> edges{from};
  for (mpreal edge = mpreal(paint.tilt) / 2; edge < to; edge *= 2) {
    if (edge > from) edges.push_back(edge);
    if (paint.orientation != Orientation::ggx && edge > 30 * paint.tilt) break;
  }
  if (edges.back() < to && (paint.orientation == Orientation::ggx || to <= 30 * paint.tilt)) {
    edges.push_back(to);
  }
  return edges;
}

mpreal shape_norm(const Paint& paint) {
  return integrate([&](const mpreal& b) { return shape(paint, b) * sin(b); },
                   pieces(paint, 0, pi() / 2));
}

// 1 - (r_s + r_p)/2 from Fresnel's amplitudes.
mpreal transmittance(const mpreal& cosine, const mpreal& eta) {
  const mpreal square = eta * eta - 1 + cosine * cosine;
  if (square <= 0) return 0;
  const mpreal g = sqrt(square);
  const mpreal s = (cosine - g) / (cosine + g);
  const mpreal p = (eta * eta * cosine - g) / (eta * eta * cosine + g);
  return 1 - (s * s + p * p) / 2;
}

// <N> without masking, of flakes of equal area; norm as above. `places` comes back as the flakes
// that fill the pixel: where it is below 1, more flakes make up for what the pixel cuts off.
mpreal mean_count(const TestScene& scene, const mpreal& norm, mpreal& places) {
  const Paint& paint = scene.paint;
  const mpreal eta = paint.binder_ior;
  const auto refracted_cosine = [&](const mpreal& c) { return sqrt(eta * eta - 1 + c * c) / eta; };
  // A light's direction is made a unit vector, an observer's is one as given.
  const mpreal lx = scene.light.x, ly = scene.light.y, lz = scene.light.z;
  const mpreal size = sqrt(lx * lx + ly * ly + lz * lz), light_z = lz / size;
  const mpreal view_in = refracted_cosine(scene.view.z), light_in = refracted_cosine(light_z);
  const mpreal x = (scene.view.x + lx / size) / eta, y = (scene.view.y + ly / size) / eta;
  const mpreal z = view_in + light_in;
  const mpreal cos_alpha = sqrt(x * x + y * y + z * z) / 2, beta = atan2(sqrt(x * x + y * y), z);

  const mpreal radius = asin(mpreal(scene.light_sine));
  const bool published = paint.radiometry == Radiometry::published;
  const mpreal outside = published ? pi() * radius * radius : 4 * pi() * pow(sin(radius / 2), 2);
  const mpreal inside = outside * light_z / (eta * eta * light_in) +
                        pi() * mpreal(paint.flake_spread) * paint.flake_spread;
  const mpreal quarter = inside / (4 * cos_alpha);
  mpreal rho = pi() / 2;
  if (quarter < 2 * pi()) rho = 2 * asin(sqrt(quarter / (4 * pi())));
  mpreal probability = shape(paint, beta) / norm * quarter / (2 * pi());
  if (!published && rho > mpreal(std::min(paint.tilt, 1.0)) / 16) {
    const auto circle = [&](const mpreal& b) -> mpreal {
      const mpreal y2 =
          sin((b + rho - beta) / 2) * sin((beta + rho - b) / 2) / (sin(beta) * sin(b));
      const mpreal arc = y2 >= 1 ? mpreal(1) : 2 * asin(sqrt(max(y2, mpreal(0)))) / pi();
      return shape(paint, b) * sin(b) * arc;
    };
    const auto whole = [&](const mpreal& b) -> mpreal { return shape(paint, b) * sin(b); };
    probability = integrate(circle, pieces(paint, abs(rho - beta), min(beta + rho, pi() / 2)));
    if (rho > beta) probability += integrate(whole, pieces(paint, 0, rho - beta));
    probability /= norm;
  }
  const mpreal exit = published ? mpreal(scene.view.z) : view_in;
  places = scene.footprint * exit /
           (pi() / 4 * pow(mpreal(paint.flake_diameter_um) / 1'000'000, 2) * cos_alpha);
  return mpreal(paint.flakes_per_mm2) * 1'000'000 * scene.footprint * min(probability, mpreal(1)) /
         min(places, mpreal(1));
}

constexpr double kDegree = std::numbers::pi / 180;
// Angles to the normal: 0, 1e-9, ..., 90 degrees less 1e-9.
struct Angle {
  double sine, cosine;
};
const Angle kAngles[] = {{0, 1},
                         {1e-9, 1},
                         {std::sin(0.3), std::cos(0.3)},
                         {std::sin(1.2), std::cos(1.2)},
                         {std::sqrt((1 - 1e-4) * (1 + 1e-4)), 1e-4},
                         {1, 1e-9 * kDegree}};

TEST_F(Mpfr, FresnelTransmittance) {
  Worst wide, narrow;
  std::vector<double> etas{0.5, 1 - 1e-12, 1, 1 + 1e-12, 4};
  std::vector<double> cosines;
  for (const Angle& angle : kAngles) cosines.push_back(angle.cosine);
  Random random = same_scenes(70);
  for (int i = 0; i < 60; ++i) {
    etas.push_back(random.uniform(0.1, 10));
    cosines.push_back(random.uniform());
  }
  for (double eta : etas) {
    // Next to total reflection as well.
    std::vector<double> all = cosines;
    if (eta < 1) {
      const double critical = std::sqrt((1 - eta) * (1 + eta));
      for (double beyond : {1e-15, 1e-12, 1e-6, 1e-3}) all.push_back(critical * (1 + beyond));
    }
    for (double cosine : all) {
      if (cosine > 1) continue;
      const auto found = [&](auto c, auto e) {
        return fresnel_transmittance(c, eta_cos_refracted(c, e), e);
      };
      wide.see(ulps_off(found(cosine, eta), transmittance(cosine, eta)), "cos", cosine, "eta", eta);
      const float c = static_cast<float>(cosine), e = static_cast<float>(eta);
      if (c * c + e * e - 1 < 0.01f) continue;  // below: g^2 is a difference of floats
      narrow.see(ulps_off(found(c, e), transmittance(c, e)), "cos", c, "eta", e);
    }
  }
  wide.expect_at_most(4, "double");
  narrow.expect_at_most(64, "float");  // a budget of 64 ulp for energies
}

TEST_F(Mpfr, SolidAngles) {
  Worst outside, ratio;
  Random random = same_scenes(71);
  for (int i = 0; i < 2'000; ++i) {
    const double sine = i < 4 ? std::array{0.0, 1e-9, 0.5, 1.0}[static_cast<std::size_t>(i)]
                              : random.log_uniform(1e-12, 1);
    const auto seen = see_light<double>({LightKind::parallel, {0, 0, 1}, sine}, {});
    const mpreal exact = 4 * pi() * pow(sin(asin(mpreal(sine)) / 2), 2);
    const auto found = 4 * std::numbers::pi_v<long double> * seen.sin2_half_radius;
    outside.see(ulps_off(static_cast<double>(found), exact), "sine", sine);
    const double cosine = random.log_uniform(1e-11, 1), eta = random.uniform(1, 10);
    const mpreal e = eta, c = cosine;
    ratio.see(ulps_off(solid_angle_ratio(cosine,
                                         static_cast<double>(eta_cos_refracted(cosine, eta)), eta),
                       c / (e * sqrt(e * e - 1 + c * c))),
              "cos", cosine, "eta", eta);
  }
  outside.expect_at_most(4, "outside");
  ratio.expect_at_most(4, "inside over outside");
}

// Scenes of every extreme: angles to 90 - 1e-9 degrees, indices about 1 and of total reflection,
// lights from 1e-9 rad to a half sphere, spikes and flat orientations.
template <class Visit>
void for_extremes(const Visit& visit) {
  Random random = same_scenes(72);
  for (int kind = 0; kind < 3; ++kind) {
    for (double tilt : {1e-6, 1e-3, 0.01, 0.05, 0.15, 0.6, kind == 0 ? 100.0 : 1.0}) {
      TestScene scene;
      scene.paint.orientation = static_cast<Orientation>(kind);
      scene.paint.tilt = rounded(tilt);
      scene.paint.flake_area_spread = 0;
      scene.normal = {0, 0, 1};
      scene.footprint = rounded(1e-2);
      const mpreal norm = shape_norm(scene.paint);
      for (double eta : {0.5, 1 - 1e-12, 1.0, 1 + 1e-12, 1.5, 4.0}) {
        for (double sine : {1e-9, 0.00465, 0.1, 1.0}) {
          for (int pair = 0; pair < (sine < 0.01 ? 6 : 2); ++pair) {
            const Angle& view = kAngles[random.below(6)];
            // Every other light stands where a flake along the normal, or near, mirrors it.
            const Angle& light = pair % 2 == 0 ? view : kAngles[random.below(6)];
            const double phi = pair % 2 == 0 ? std::numbers::pi * (1 + 1e-3 * random.uniform())
                                             : random.uniform(0, 6.28);
            scene.paint.binder_ior = eta;
            scene.paint.flake_spread = pair == 0 ? 0.005 : 0;
            scene.paint.radiometry = static_cast<Radiometry>(pair == 3);
            scene.light_sine = rounded(sine);
            scene.view = {view.sine, 0, view.cosine};
            scene.light = {light.sine * std::cos(phi), light.sine * std::sin(phi), light.cosine};
            visit(scene, norm);
          }
        }
      }
    }
  }
}

TEST_F(Mpfr, MeanCountInDouble) {
  Worst ordinary, along;
  for_extremes([&](const TestScene& scene, const mpreal& norm) {
    const double found = scene.expect<double>().mean_count;
    const double square = scene.paint.binder_ior * scene.paint.binder_ior - 1;
    const double least = std::min(scene.view.z, scene.light.z);
    if (square + least * least <= 0) {
      EXPECT_EQ(found, 0) << "total reflection: " << scene;
      return;
    }
    mpreal places;
    const mpreal exact = mean_count(scene, norm, places);
    if (places < kPoissonSlots && exact > max(floor(places), mpreal(1))) return;  // crowded
    if (exact < 1e-60) {
      EXPECT_LE(found, 1e-60) << scene;
      return;
    }
    // Both directions along a surface that does not refract: the flake between them follows from
    // differences of 1e-4 and less, which long double knows to 5e-20.
    const bool is_along = scene.view.z + scene.light.z < 1e-3 && std::fabs(square) < 1e-6;
    (is_along ? along : ordinary).see(ulps_off(found, exact), scene);
  });
  // Of nine runs with fresh scenes 19.5 was the largest, of a spike under grazing light.
  ordinary.expect_at_most(24, "all but these");
  along.expect_at_most(1000, "along the surface");
}

// The ordinary range: tilts from 0.05, flakes up to 4 tilts, angles to 80 degrees, lights to 0.3
// rad.
TEST_F(Mpfr, MeanCountInFloat) {
  Worst narrow, wide;
  Random random = same_scenes(73);
  for (int k = 0; k < 40; ++k) {
    TestScene scene;
    scene.paint = random_paint(random);
    scene.paint.flake_area_spread = 0;
    scene.paint.depth_model = DepthModel::attenuated;
    const mpreal norm = shape_norm(scene.paint);
    for (int i = 0; i < 50; ++i) {
      aim(scene, random, 4, false);
      scene = rounded(scene);
      scene.light_sine = rounded(random.log_uniform(1e-3, 0.3));
      scene.footprint = rounded(1e-2);
      const float found = scene.expect<float>().mean_count;
      mpreal places;
      const mpreal exact = mean_count(scene, norm, places);
      if (exact < 1e-4 || places < kPoissonSlots) continue;
      (is_narrow(scene) ? narrow : wide).see(relative(found, exact), scene);
    }
  }
  narrow.expect_at_most(1e-5, "P at the light's centre");
  wide.expect_at_most(1e-5, "integrated over the light");
}

}  // namespace
