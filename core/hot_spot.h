// SPDX-License-Identifier: Apache-2.0
//
// DepthModel::correlated (ours): what hides a flake from the observer often hides it from the light
// as well, which vegetation science calls the hot spot (Kuusk 1991). The paper, 5.3.3, takes the
// two ways for independent.
//
// Let discs of diameter D lie level in a layer of thickness H, their centres Poisson, c of them
// over each point. At the height h above a flake its two ways to the surface lie delta h apart,
//   delta = |tan(theta_p) - tan(theta'_p)|, the tangents as vectors in the plane.
// A disc that both ways meet hides once, not twice. Two discs of diameter D about points x apart
// share O(x/D) of their area, O(u) = (2/pi)(acos(u) - u sqrt(1 - u^2)). So from the depth z, a
// share of the layer, both ways are free with the probability
//   P(z) = exp(-x z + c z K(w z)),  K(y) = integral of O(y t) over t in [0, 1],  w = delta H/D,
// where x is the optical depth there and back. Tilted flakes have c = D H <S> <cos(beta)>, what
// either way meets where it meets no flake's back. A flake that transmits t is met twice by one
// ray: it shares (1 - t)^2. Each species has its own G; together they have its mean over what they
// cover.
//
// The lacquer covers all flakes: the layer holds their centres, and what of a flake sticks out of
// its top hides as the rest does. P does not know of that part. So x' has the mean of discs traced
// one by one within 3 %, and h below the mean square within 6 %, for binders of index 1.3 to 1.8
// and any angle where what sticks out is small: the sum over the species of coverage x D/H x tilt
// up to 0.3, with coverages up to 3, D/H up to 2 and tilts up to 0.4. At 1.2 (coverage 3, D = H,
// tilt 0.4) the model is too bright: along the normal by 2 %, at 45 degrees by 10 % (index 1.33),
// at 75 degrees by 13 % (10 % with index 1.8). See tests/core/hot_spot_test.cpp.
//
// Everything else takes an optical depth as before: the x' = x - c G(w, x) that leaves the same
// mean,
//   (1 - e^-x')/x' = integral of P(z) over z in [0, 1].
//
// What hides a disc hides all of it or a part: its free share s varies. Two points of it, d apart,
// are both free with e^-c(4 - ...)z, where what covers both counts once: of one way O(d/D), on
// average over the disc kappa, of two ways far apart twice that. So the square of s is that of
// e^-x'z, but for h = kappa c (2 - G):
//   E[s^2] = A(2 x' - h),  A(x) = (1 - e^-x)/x,
// as if the part h of the depth took flakes away whole, and the part x' - h dimmed those that are
// left. So they are drawn, and E[s^n] = A(n x' - (n - 1) h). A flake that transmits t and lies on i
// ways of one point and j of the other takes (1 - t^i)(1 - t^j) from the sum of both points'
// depths: (1 - t)^2 on one way, (1 - t^2)^2 on both. The latter is more by b in all:
//   h = kappa (c (2 - G) + b G).
// Of several species it is the mean over what they cover, as G is.
#pragma once

#include <algorithm>

#include "layer.h"
#include "optical_thickness.h"
#include "vector.h"

namespace metallic_paint {

// G(w, x), the share of c that counts, is 1 where both ways are one. It falls as 1 - 0.4 w for
// small w and x, as 0.42/(w <z>) for large w. Fitted to the integral: for c of 0.02 to 5, any w and
// x from 2 c to 2 c + 40 the mean is within 1.2 % (docs/fits.md).
template <class T>
T share_in_common(T w, T x) {
  const T y = w / (1 + T(0.0971) * x);
  return (1 + T(1.6392) * y) / (1 + y * (T(2.0389) + y * (T(1.8717) / (1 + T(0.1464) * x))));
}

// kappa where both ways are one, for a disc r times as wide as those that hide it; 0.465 = E[O]
// where r = 1.
template <class T>
T hidden_one_way(T r) {
  return 1 / (1 + r * (T(0.3259) + T(0.8235) * r));
}

// kappa of G. Fitted to four discs' union: for c of 0.1 to 3, w above 0.05, x - 2 c of 0 to 5 and r
// of 0.4 to 2.5 E[s^2] is within 4 %, for r of 0.05 to 20 within 4.5 %; of two species within 3.5 %
// (docs/fits.md).
template <class T>
T hidden_at_once(T one_way, T share) {
  const T more = (1 - one_way) * (T(0.74) + T(0.45) * one_way);
  return one_way + more * (share * (1 - share));
}

// The mean of numbers or colours over the species, by what each covers.
template <class T, class Of>
auto among_species(const Layer<T>& layer, const Of& of) {
  if (layer.species == 1) return of(std::size_t{0});
  auto sum = of(std::size_t{0}) * layer.hiding[0];
  for (std::size_t i = 1; i < static_cast<std::size_t>(layer.species); ++i) {
    sum = sum + of(i) * layer.hiding[i];
  }
  return sum;
}

// G of delta of a species: it hides by its own width.
template <class T>
T share_in_common(const Layer<T>& layer, std::size_t species, T delta, T x) {
  return share_in_common(min(delta * layer.thickness_in_flakes[species], T(1e9)), x);
}

template <class T>
T share_in_common(const Layer<T>& layer, T delta, T x) {
  return among_species(layer, [&](std::size_t i) { return share_in_common(layer, i, delta, x); });
}

// What the substrate scatters straight back comes and goes by the same holes. It lies g below the
// layer, where the lowest flakes end, so that both ways are free with the probability
//   exp(-x + c k),  k = integral of O((g + t H) delta/D) over t in [0, 1].
// O is 1 - (4/pi) u + u^3/(3 pi/2) + ..., here with a last term that leaves the integral over [0,
// 1] at its 4/(3 pi); C is within 0.001. Divided by w, the difference of two values of C is written
// out, so that it keeps its digits.
template <class T>
T holes_in_common(T w, T g) {
  const T way = max(w, T(1e-3));
  const T u = min(g, T(1)), v = min(g + way, T(1));
  const T sum = u + v, squares = u * u + v * v, product = u * v;
  const T mean = 1 - sum * (T(0.63662) - (T(0.05305) * squares +
                                          T(0.00798) * (squares * squares - product * product)));
  return max((v - u) / way * mean, T(0));
}

template <class T>
T holes_in_common(const Layer<T>& layer, T delta) {
  return among_species(layer, [&](std::size_t i) {
    return holes_in_common(min(delta * layer.thickness_in_flakes[i], T(1e9)),
                           min(delta * layer.gap_in_flakes[i], T(1e9)));
  });
}

// x' of x and G. No more is shared than either way has: t_p at another angle may say otherwise.
template <class T>
Rgb<T> less_in_common(const Layer<T>& layer, Rgb<T> x, Rgb<T> share) {
  return x - least(layer.shared_blocking, x * T(0.5)) * share;
}

// The ways there and back of a light in the binder: the sum of their optical depths, and G of each
// species.
template <class T>
struct BothWays {
  Rgb<T> sum{};
  std::array<Rgb<T>, kSpecies> shared{};
};

template <class T>
BothWays<T> both_ways(const Layer<T>& layer, Rgb<T> view_slant, Rgb<T> light_slant, T delta) {
  BothWays<T> ways{view_slant + light_slant, {}};
  if (layer.depth_model != DepthModel::correlated) return ways;
  for (std::size_t i = 0; i < static_cast<std::size_t>(layer.species); ++i) {
    ways.shared[i] = map(ways.sum, [&](T x) { return share_in_common(layer, i, delta, x); });
  }
  return ways;
}

template <class T>
Rgb<T> share_in_common(const Layer<T>& layer, const BothWays<T>& ways) {
  return among_species(layer, [&](std::size_t i) { return ways.shared[i]; });
}

// Their optical depth as one.
template <class T>
Rgb<T> there_and_back(const Layer<T>& layer, const BothWays<T>& ways) {
  if (layer.depth_model != DepthModel::correlated) return ways.sum;
  return less_in_common(layer, ways.sum, share_in_common(layer, ways));
}

template <class T>
Rgb<T> there_and_back(const Layer<T>& layer, Rgb<T> view_slant, Rgb<T> light_slant, T delta) {
  return there_and_back(layer, both_ways(layer, view_slant, light_slant, delta));
}

// h of the flakes of a species: one number for all colours, the least of theirs. `x` is these ways'
// depth as one.
template <class T>
T hidden_whole(const Layer<T>& layer, const Flakes<T>& flakes, Rgb<T> x, const BothWays<T>& ways) {
  if (layer.depth_model != DepthModel::correlated) return T(0);
  const Rgb<T> b = layer.blocking_again, c = least(layer.shared_blocking, ways.sum * T(0.5));
  const Rgb<T> hidden = among_species(layer, [&](std::size_t i) {
    const T one_way = hidden_one_way(flakes.diameter / layer.diameters[i]);
    const Rgb<T> share = ways.shared[i];
    return map(share, [&](T g) { return hidden_at_once(one_way, g); }) *
           (c * (grey(T(2)) - share) + b * share);
  });
  const Rgb<T> h = least(hidden, x);
  return min(min(h.x, h.y), h.z);
}

// delta of two unit vectors away from the surface, outside; g is eta times a cosine in the binder.
template <class T>
T ways_apart(Vec3<T> normal, Vec3<T> view, T cos_view, T g_view, Vec3<T> light, T cos_light,
             T g_light) {
  return length((view - normal * cos_view) * (1 / max(g_view, T(kLeastCosine))) -
                (light - normal * cos_light) * (1 / max(g_light, T(kLeastCosine))));
}

}  // namespace metallic_paint
