// SPDX-License-Identifier: Apache-2.0
#include "view_and_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "optics.h"
#include "spiral.h"

namespace metallic_paint::reference {
namespace {

constexpr double kPi = std::numbers::pi;

// Of those of the light's directions that lie within a flake's disc.
LightMet meet_within_spread(const ViewAndLight& at, double spread, Vec3<double> mirrored,
                            RandomStream& random) {
  LightMet met;
  // Refraction into a denser binder brings directions closer together.
  const bool closer = at.eta >= 1 && at.light_in.z > 0;
  const double reach2 = closer ? square(spread + std::sqrt(at.light_chord2)) * (1 + 1e-9) : 4;
  const Vec3<double> off = mirrored - at.light_in;
  if (dot(off, off) > reach2) return met;
  const Frame frame = frame_of(at.light);
  const Spiral spiral(at.light_points, random);
  for (int i = 0; i < at.light_points; ++i) {
    const double x = spiral.area_within(i) * at.light_chord2 / 2;  // 1 - cos
    const double radius = std::sqrt(x * (2 - x)), angle = spiral.angle(i);
    const Vec3<double> point = at.light * (1 - x) + frame.a * (radius * std::cos(angle)) +
                               frame.b * (radius * std::sin(angle));
    const Vec3<double> in = refracted(point, at.eta);
    if (in.z == 0) continue;
    const Vec3<double> away = in - mirrored;
    if (dot(away, away) > spread * spread) continue;
    met.received += (1 - fresnel_reflectance(point.z, in.z, at.eta)) * point.z /
                    (at.eta * at.eta * in.z) / (kPi * spread * spread * at.light_points);
    met.towards = met.towards + in;
  }
  if (met.received > 0) met.towards = met.towards / length(met.towards);
  return met;
}

}  // namespace

ViewAndLight::ViewAndLight(const ExplicitScene& scene)
    : eta(scene.paint.binder_ior),
      view(scene.view / length(scene.view)),
      light(scene.light / length(scene.light)),
      view_in(refracted(view, eta)),
      light_in(refracted(light, eta)),
      seen(light.z > 0 && view_in.z > 0),
      view_transmittance(1 - fresnel_reflectance(view.z, view_in.z, eta)),
      light_chord2(square(2 * std::sin(scene.light_radius / 2))),
      light_solid_angle(kPi * light_chord2),  // 4 pi sin^2(radius/2)
      light_points(light_chord2 > 0 ? scene.points : 1) {
  const double angle = std::acos(std::min(light.z, 1.0));
  const double from = std::min(angle + scene.light_radius, kPi / 2);
  least_cosine = refracted_cosine(std::cos(from), eta);
  most_cosine = refracted_cosine(std::cos(std::max(angle - scene.light_radius, 0.0)), eta);
}

LightMet meet_light(const ViewAndLight& at, const Population& flakes, Vec3<double> mirrored,
                    RandomStream& random) {
  // The integral of 1/Omega over those directions of the light within the flake's own disc, divided
  // by its solid angle pi spread^2; d omega inside/outside = cos/(eta^2 cos_p). A cap of that solid
  // angle holds what is within a chord of `spread`.
  if (flakes.spread > 0) return meet_within_spread(at, flakes.spread, mirrored, random);
  // The light's own radiance, 1/Omega.
  LightMet met;
  const Vec3<double> out = refracted(mirrored, 1 / at.eta);
  if (out.z == 0) return met;
  const Vec3<double> off = out - at.light;
  if (dot(off, off) > at.light_chord2) return met;
  met.received = (1 - fresnel_reflectance(out.z, mirrored.z, at.eta)) / at.light_solid_angle;
  met.towards = mirrored;
  return met;
}

}  // namespace metallic_paint::reference
