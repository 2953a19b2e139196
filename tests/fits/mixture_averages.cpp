// SPDX-License-Identifier: Apache-2.0
//
// What core/mixture.h puts in place of averages over the flakes' normals, against these averages:
// mixture_averages [SEED]. Random flakes of the range that mixture.h names, their normals by a
// lattice. A table on the output; 1 minute on one core.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "mixture_scenes.h"

namespace {

using namespace core_tests;

constexpr int kCases = 2000;

// Of each case the largest error over the three colours, by name; told as a table.
class Errors {
 public:
  void see(const std::string& name, double error) { all_[name].push_back(std::fabs(error)); }
  void see(const std::string& name, Rgb<double> error) {
    see(name, max_component(map(error, [](double x) { return std::fabs(x); })));
  }
  void tell() {
    for (auto& [name, errors] : all_) {
      std::sort(errors.begin(), errors.end());
      const auto at = [&](double share) {
        return errors[static_cast<std::size_t>(share * static_cast<double>(errors.size() - 1))];
      };
      std::printf("| %s | %.2g | %.2g | %.2g |\n", name.c_str(), at(1), at(0.95), at(0.5));
    }
  }

 private:
  std::map<std::string, std::vector<double>> all_;
};

// The flakes' normals by Fibonacci's lattice: see(normal, share).
template <class See>
void over_normals(const OrientationDensity<double>& density, int points, int generator,
                  const See& see) {
  for (int i = 0; i < points; ++i) {
    const SampledTilt<double> tilt = sample_tilt(density, (i + 0.5) / points);
    const auto turn = static_cast<int>(static_cast<long>(i) * generator % points);
    const double phi = std::numbers::pi * (turn + 0.5) / points;
    const double h = tilt.sin2_half_beta, sin_beta = 2 * std::sqrt(h * (1 - h));
    see(Vec3<double>{sin_beta * std::cos(phi), sin_beta * std::sin(phi), 1 - 2 * h},
        tilt.weight / points);
  }
}

double transmitted(double cos_in, double eta) {
  const double inside = 1 - (1 - cos_in * cos_in) * eta * eta;
  if (!(inside > 0)) return 0;
  const double cos_out = std::sqrt(inside);
  return fresnel_transmittance(cos_out, eta_cos_refracted(cos_out, eta), eta);
}

// What becomes of light from the cosines [from, to], even in the cosine (Lambertian light per
// path): averages over all that the flakes meet.
struct Met {
  double area = 0;      // <s>
  double cone = 0;      // mirrored into the cone that the surface lets out, up or down
  double escaping = 0;  // of that, what it does let out
  Rgb<double> reflected{}, transmitted{};
};

Met meet(const OrientationDensity<double>& density, const Coating<double>& coating, double eta,
         double critical, double from, double to) {
  const int slants = from < to ? 24 : 1;
  Met sum;
  for (int i = 0; i < slants; ++i) {
    const double c = from + (to - from) * (i + 0.5) / slants, s = std::sqrt(1 - c * c);
    const int points = slants > 1 ? 2584 : 121393, generator = slants > 1 ? 1597 : 75025;
    over_normals(density, points, generator, [&](Vec3<double> m, double share) {
      const double cosine = s * m.x + c * m.z, weight = share * std::fabs(cosine) / slants;
      const double along = 2 * cosine * m.z - c;
      sum.area += weight;
      if (std::fabs(along) > critical) sum.cone += weight;
      sum.escaping += weight * transmitted(std::fabs(along), eta);
      sum.reflected =
          sum.reflected + coating_reflectance(coating, std::min(std::fabs(cosine), 1.0)) * weight;
      sum.transmitted = sum.transmitted +
                        coating_transmittance(coating, std::min(std::fabs(cosine), 1.0)) * weight;
    });
  }
  return sum;
}

std::string kind_of(const Coating<double>& coating) {
  const int kind = static_cast<int>(coating.kind);
  if (kind == 0) return "own colours";
  if (!is_clear(coating.kind)) return "metals";
  return coating.kind == CoatingKind::tio2_on_mica || coating.kind == CoatingKind::fe2o3_on_mica
             ? "pearls on mica"
             : "pearls on silica";
}

// The share of Lambertian light that `turned` is of, against z = sin(beta) of a typical flake.
struct Turned {
  double z, share;
};

// Least squares of a z/(1 + b z^2): share = a z - b z^2 share is linear in a and b; weighted again
// by 1/(1 + b z^2) until it is the square of share's own error.
void fit_turned(const std::vector<Turned>& all) {
  double a = 2, b = 2;
  for (int round = 0; round < 20; ++round) {
    double xx = 0, xy = 0, yy = 0, xs = 0, ys = 0;
    for (const auto& [z, share] : all) {
      const double w = 1 / ((1 + b * z * z) * (1 + b * z * z)), x = z, y = -z * z * share;
      xx += w * x * x;
      xy += w * x * y;
      yy += w * y * y;
      xs += w * x * share;
      ys += w * y * share;
    }
    const double det = xx * yy - xy * xy;
    a = (xs * yy - ys * xy) / det;
    b = (ys * xx - xs * xy) / det;
  }
  double worst = 0, square = 0;
  for (const auto& [z, share] : all) {
    const double off = a * z / (1 + b * z * z) - share;
    worst = std::max(worst, std::fabs(off));
    square += off * off / static_cast<double>(all.size());
  }
  std::printf(
      "\nturned, fitted again: a z/(1 + b z^2), a = %.3f, b = %.3f: largest error %.2g, root"
      " mean square %.2g of Lambertian light's\n",
      a, b, worst, std::sqrt(square));
  worst = square = 0;
  for (const auto& [z, share] : all) {
    const double off = 2 * z / (1 + 2 * z * z) - share;
    worst = std::max(worst, std::fabs(off));
    square += off * off / static_cast<double>(all.size());
  }
  std::printf("as it stands, a = b = 2: %.2g and %.2g\n", worst, std::sqrt(square));
}

void see_case(Random& random, Errors& errors, std::vector<Turned>& all_turned) {
  SeenPaint seen =
      over_white(random, random.below(2) == 0 ? ordinary_paint(random) : library_paint(random));
  const Layer<double> layer = make_layer<double>(seen.paint);
  const Flakes<double>& flakes = layer.flakes[0];
  const OrientationDensity<double>& density = flakes.orientation;
  const double eta = layer.eta;
  const double cos_in = eta_cos_refracted(seen.cos_view, eta) / eta;
  const DiffuseSurface<double> surface = diffuse_surface(eta);

  double transmittance = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double c = (i + 0.5) / 20'000;
    transmittance += 2 * c / 20'000 * fresnel_transmittance(c, eta_cos_refracted(c, eta), eta);
  }
  errors.see("mean transmittance of the surface, three points",
             surface.transmittance - transmittance);

  const double critical = surface.critical;
  const Met g = meet(density, flakes.coating, eta, critical, cos_in, cos_in);
  const Mirroring<double> mirrored =
      mirror_out(layer, flakes, surface, cos_in, slant_depth_of(layer, cos_in));
  const std::string kind = kind_of(flakes.coating);
  errors.see("mirror_out, share that leaves", (mirrored.escaping - g.escaping) / g.area);
  const Met c = meet(density, flakes.coating, eta, critical, critical, 1);
  const Met o = meet(density, flakes.coating, eta, critical, 0, critical);
  const auto of = [&](const std::string& light, const Met& met, double cosine) {
    errors.see("r_p at a typical angle, " + light + ", " + kind,
               coating_reflectance(flakes.coating, cosine) - met.reflected / met.area);
  };
  of("g", g, cos_in);
  of("c", c, (1 + critical) / 2);
  of("o", o, critical / 2);
  // Per area of the layer: the mean of <s>/cos over Lambertian light is (2/(1 + critical)) <s>.
  errors.see("mean projected area over cosine, c, as the mean cosine of the tilt",
             2 / (1 + critical) * c.area - density.mean_cos);
  const double z = std::sqrt((1 - density.mean_cos) * (1 + density.mean_cos));
  const double lambertian = surface.cone * transmittance;
  all_turned.push_back({z, o.escaping / o.area / lambertian});

  // Of what the pigment sends, between the share by flux and that by solid angle.
  errors.see("from_pigment, half of the way between its ends",
             (1 - critical - surface.cone) * transmittance / 2);

  // E as the mixture estimates it.
  DiffuseRates<double> diffuse_light;
  FlakeRates<double> rates;
  const Rgb<double> slant = slant_depth_of(layer, cos_in);
  for (int i = 0; i < layer.species; ++i) {
    const Flakes<double>& some = layer.flakes[static_cast<std::size_t>(i)];
    add_diffuse(diffuse_light, diffuse_rates(some, surface));
    if (some.coverage > 0) add_flakes(rates, layer, some, surface, cos_in, slant);
  }
  const double entered = 1 - surface_of(seen.paint, seen.cos_view);
  const bool silica = has_silica(seen.paint);
  errors.see(std::string("E as M estimates it, ") + (silica ? "with silica" : "without silica"),
             rates.single.independent * entered - single_scattering(seen.paint, seen.cos_view));
  // Likewise of flakes that are 0.1 to 2 layers wide, of what both ways share besides.
  Paint shared = seen.paint;
  shared.depth_model = DepthModel::correlated;
  shared.layer_thickness_um = shared.flake_diameter_um / random.log_uniform(0.1, 2);
  const Layer<double> thin = make_layer<double>(shared);
  FlakeRates<double> both;
  for (int i = 0; i < thin.species; ++i) {
    const Flakes<double>& some = thin.flakes[static_cast<std::size_t>(i)];
    if (some.coverage > 0) {
      add_flakes(both, thin, some, surface, cos_in, slant_depth_of(thin, cos_in));
    }
  }
  errors.see(std::string("E as M estimates it, correlated, ") +
                 (silica ? "with silica" : "without silica"),
             both.single.correlated * entered - single_scattering(shared, seen.cos_view));
}

// A lossless paint in binders thinner than those of the stated range.
void see_thin_binder(Random& random, Errors& errors, const std::string& name, double from,
                     double to) {
  SeenPaint seen = over_white(random, ordinary_paint(random, true));
  seen.paint.binder_ior = random.uniform(from, to);
  const Rgb<double> m = albedo_of<double>(seen.paint, seen.substrate, seen.cos_view);
  errors.see("r_s + E + M off 1, index from " + name,
             single_scattering(seen.paint, seen.cos_view) + m -
                 grey(1 - surface_of(seen.paint, seen.cos_view)));
}

}  // namespace

int main(int argc, char** argv) {
  std::random_device system;
  const std::uint64_t seed = argc > 1 ? std::stoull(argv[1]) : system();
  std::printf("Seed %llu, %d cases.\n\n", static_cast<unsigned long long>(seed), kCases);
  std::printf("| error of | largest | 95 %% | median |\n| --- | ---: | ---: | ---: |\n");
  Random random(seed);
  Errors errors;
  std::vector<Turned> turned;
  for (int i = 0; i < kCases; ++i) {
    see_case(random, errors, turned);
    see_thin_binder(random, errors, "1.05 to 1.33", 1.05, 1.33);
    see_thin_binder(random, errors, "0.6 to 1", 0.6, 1);
    if ((i + 1) % 200 == 0) std::cerr << i + 1 << " of " << kCases << " cases\n";
  }
  errors.tell();
  fit_turned(turned);
}
