// SPDX-License-Identifier: Apache-2.0
//
// The errors that core/mixture.h states, over fresh random paints. Two steps, so that the second,
// of seconds, can be run again with other constants (fits.py does):
//
//   mixture_error walk FILE [SEEDS [FIRST]]  walks through the paints of SEEDS (200) seeds, writes
//                                            what was found to FILE; 40 minutes on one core
//   mixture_error compare FILE               what the mixture errs there, as rows of a table
//
// The seeds are FIRST, FIRST + 1 and so on; without FIRST they are the system's, and printed.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "mixture_scenes.h"

namespace {

using namespace core_tests;

struct Kind {
  const char* name;
  int paints;  // of each seed
  SeenPaint (*make)(Random&);
};

// Under uniform light, against the walk.
constexpr Kind kWalked[] = {
    {"ordinary", 60, [](Random& r) { return over_any_substrate(r, ordinary_paint(r)); }},
    {"library", 60, [](Random& r) { return over_any_substrate(r, library_paint(r)); }},
};
// Likewise, against 1.
constexpr Kind kLossless[] = {
    {"lossless", 20, [](Random& r) { return over_white(r, ordinary_paint(r, true)); }},
    {"lossless mica", 20, [](Random& r) { return over_white(r, lossless_pearl(r, true)); }},
    {"lossless silica", 20, [](Random& r) { return over_white(r, lossless_pearl(r, false)); }},
};
// By angle.
constexpr Kind kByAngle = {"by angle", 5,
                           [](Random& r) { return over_black(r, ordinary_paint(r)); }};

std::vector<SeenPaint> seen_paints(const Kind& kind, std::uint64_t seed) {
  Random random(seed);
  std::vector<SeenPaint> all;
  for (int i = 0; i < kind.paints; ++i) all.push_back(kind.make(random));
  return all;
}

// A first walk tells which paints may have a large error; these are walked again with more photons,
// and so are the first paints of each seed, for the errors of all.
constexpr std::size_t kPhotons = 10'000, kManyPhotons = 250'000, kAnglePhotons = 30'000;
constexpr double kLarge = 0.016;  // the first walk's own standard error is 0.005 at most
constexpr int kSurePaints = 2;

class Progress {
 public:
  explicit Progress(int seeds) : seeds_(seeds) {}
  void tell(int done) const {
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start_;
    const double left = taken.count() / done * (seeds_ - done);
    std::cerr << "seed " << done << " of " << seeds_ << ", " << static_cast<int>(left / 60)
              << " min left\n";
  }

 private:
  int seeds_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

std::ostream& operator<<(std::ostream& out, Rgb<double> c) {
  return out << ' ' << c.x << ' ' << c.y << ' ' << c.z;
}
std::istream& operator>>(std::istream& in, Rgb<double>& c) { return in >> c.x >> c.y >> c.z; }

double largest(Rgb<double> c) {
  return max_component(map(c, [](double x) { return std::fabs(x); }));
}

void walk_seed(std::ostream& out, std::uint64_t seed) {
  out << seed << '\n';
  for (const Kind& kind : kWalked) {
    int index = 0;
    for (const SeenPaint& seen : seen_paints(kind, seed)) {
      const std::uint64_t photon_seed = seed + static_cast<std::uint64_t>(index);
      const Rgb<double> e = single_scattering(seen.paint, seen.cos_view);
      std::size_t photons = kManyPhotons;
      if (index >= kSurePaints) {
        const Rgb<double> m = albedo_of<double>(seen.paint, seen.substrate, seen.cos_view);
        const Rgb<double> walked = walked_albedo(seen, kPhotons, ~photon_seed).mean;
        if (!(largest(e + m - walked) > kLarge)) photons = 0;
      }
      if (photons > 0) {
        const reference::Estimate walked = walked_albedo(seen, photons, photon_seed);
        out << index << e << walked.mean << walked.error << '\n';
      }
      ++index;
    }
    out << "-1\n";
  }
  for (const Kind& kind : kLossless) {
    for (const SeenPaint& seen : seen_paints(kind, seed)) {
      out << single_scattering(seen.paint, seen.cos_view) << '\n';
    }
  }
  for (const SeenPaint& seen : seen_paints(kByAngle, seed)) {
    const ByAngle factors = walked_by_angle(seen, kAnglePhotons, seed);
    for (std::size_t i = 0; i < kDirections; ++i) {
      out << factors.single[i] << ' ' << factors.whole[i] << ' ';
    }
    out << '\n';
  }
}

void walk(const std::string& file, int seeds, std::uint64_t first) {
  std::cerr << "seeds " << first << " to " << first + static_cast<std::uint64_t>(seeds - 1) << '\n';
  const std::string part = file + ".part";
  std::ofstream out(part);
  out.precision(9);
  const Progress progress(seeds);
  for (int i = 0; i < seeds; ++i) {
    walk_seed(out, first + static_cast<std::uint64_t>(i));
    progress.tell(i + 1);
  }
  out.close();
  if (!out) throw std::runtime_error("cannot write " + part);
  std::filesystem::rename(part, file);
}

// --- compared --------------------------------------------------------------------------------

struct Walked {
  SeenPaint seen;
  Rgb<double> e, mean, error;
  bool sure;  // one of those that stand for all
};

struct Found {
  std::string runs;  // of consecutive seeds, by the first of each
  std::vector<std::vector<Walked>> walked[std::size(kWalked)];  // by seed
  int paints[std::size(kWalked)][2] = {};                       // without silica, with it
  std::vector<Walked> lossless[std::size(kLossless)];           // mean 1, no error
  std::vector<std::pair<SeenPaint, ByAngle>> by_angle;
};

Found read(const std::string& file) {
  std::ifstream in(file);
  Found found;
  std::uint64_t seed = 0, last = 0;
  while (in >> seed) {
    if (found.by_angle.empty() || seed != last + 1) found.runs += ' ' + std::to_string(seed);
    last = seed;
    for (std::size_t k = 0; k < std::size(kWalked); ++k) {
      const std::vector<SeenPaint> seen = seen_paints(kWalked[k], seed);
      for (const SeenPaint& one : seen) ++found.paints[k][has_silica(one.paint) ? 1 : 0];
      std::vector<Walked>& all = found.walked[k].emplace_back();
      for (int i = 0; in >> i && i >= 0;) {
        Walked walked{seen.at(static_cast<std::size_t>(i)), {}, {}, {}, i < kSurePaints};
        in >> walked.e >> walked.mean >> walked.error;
        all.push_back(walked);
      }
    }
    for (std::size_t k = 0; k < std::size(kLossless); ++k) {
      for (const SeenPaint& seen : seen_paints(kLossless[k], seed)) {
        const double surface = surface_of(seen.paint, seen.cos_view);
        Walked whole{seen, {}, grey(1 - surface), {}, true};
        in >> whole.e;
        found.lossless[k].push_back(whole);
      }
    }
    for (const SeenPaint& seen : seen_paints(kByAngle, seed)) {
      ByAngle factors{};
      for (std::size_t i = 0; i < kDirections; ++i) in >> factors.single[i] >> factors.whole[i];
      found.by_angle.emplace_back(seen, factors);
    }
    if (!in) throw std::runtime_error(file + " ends within seed " + std::to_string(seed));
  }
  if (found.by_angle.empty()) throw std::runtime_error(file + " holds no walks");
  return found;
}

// Of few seeds a row may stand for no value at all, or its deviation for a single one.
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// A row of the table.
void tell(const std::string& what, double value) {
  if (std::isnan(value)) {
    std::printf("| %s | of too few |\n", what.c_str());
  } else {
    std::printf("| %s | %.5g |\n", what.c_str(), value);
  }
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return kNone;
  std::sort(values.begin(), values.end());
  return values.at(static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5));
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return kNone;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  if (values.size() < 2) return kNone;
  double square = 0;
  for (double x : values) square += (x - mean(values)) * (x - mean(values));
  return std::sqrt(square / static_cast<double>(values.size() - 1));
}

// What a maximum passes with the probability 1e-5, by Gumbel's law with the same moments.
double rarely_passed(const std::vector<double>& maxima) {
  const double scale = deviation(maxima) * std::sqrt(6.0) / std::numbers::pi;
  return mean(maxima) + scale * (std::log(1e5) - std::numbers::egamma);
}

void tell_quantiles(const std::string& of, const std::vector<double>& values) {
  tell(of + ", largest", quantile(values, 1));
  tell(of + ", 99 %", quantile(values, 0.99));
  tell(of + ", 95 %", quantile(values, 0.95));
  tell(of + ", median", quantile(values, 0.5));
}

Rgb<double> off(const Walked& one) {
  return one.e + albedo_of<double>(one.seen.paint, one.seen.substrate, one.seen.cos_view) -
         one.mean;
}

void compare_walks(const std::string& kind, const Found& found, std::size_t k, bool silica) {
  std::vector<double> all, relative, worst_of_paint, mean_of_paint, worst_of_seed;
  double square = 0, walks_own = 0;
  for (const std::vector<Walked>& seed : found.walked[k]) {
    double worst = 0;
    for (const Walked& one : seed) {
      if (has_silica(one.seen.paint) != silica) continue;
      const Rgb<double> error = off(one);
      worst = std::max(worst, largest(error));
      if (!one.sure) continue;
      worst_of_paint.push_back(largest(error));
      mean_of_paint.push_back(0);
      for (auto c : {&Rgb<double>::x, &Rgb<double>::y, &Rgb<double>::z}) {
        all.push_back(std::fabs(error.*c));
        mean_of_paint.back() += std::fabs(error.*c) / 3;
        square += error.*c * (error.*c);
        walks_own += one.error.*c * (one.error.*c);
        const double scattered = one.mean.*c - one.e.*c;
        if (scattered > 0.02) relative.push_back(std::fabs(error.*c) / scattered);
      }
    }
    if (worst > 0) worst_of_seed.push_back(worst);
  }
  const auto n = static_cast<double>(all.size());
  tell(kind + ": paints", found.paints[k][silica ? 1 : 0]);
  tell(kind + ": of these so many stand for all", n / 3);
  tell_quantiles(kind + ": largest error of M in a seed's paints", worst_of_seed);
  tell(kind + ": what that passes once in 1e5, by Gumbel's law", rarely_passed(worst_of_seed));
  tell_quantiles(kind + ": error of M", all);
  tell(kind + ": error of M, root mean square less the walk's own",
       std::sqrt(std::max(square - walks_own, 0.0) / n));
  tell(kind + ": the walk's own standard error, root mean square", std::sqrt(walks_own / n));
  tell(kind + ": error of M, worst of the three colours, 95 %", quantile(worst_of_paint, 0.95));
  tell(kind + ": error of M, mean of the three colours, mean", mean(mean_of_paint));
  tell(kind + ": error of M, mean of the three colours, deviation", deviation(mean_of_paint));
  tell(kind + ": error over M, where M > 0.02, 95 %", quantile(relative, 0.95));
  tell(kind + ": error over M, where M > 0.02, median", quantile(relative, 0.5));
}

void compare_furnace(const Kind& kind, const std::vector<Walked>& all) {
  std::vector<double> errors, worst_of_seed;
  for (const Walked& one : all) {
    if (errors.size() % static_cast<std::size_t>(kind.paints) == 0) worst_of_seed.push_back(0);
    errors.push_back(largest(off(one)));
    worst_of_seed.back() = std::max(worst_of_seed.back(), errors.back());
  }
  const std::string name = kind.name;
  tell(name + ": paints", static_cast<double>(errors.size()));
  tell_quantiles(name + ": r_s + E + M off 1", errors);
  tell(name + ": what the largest of a seed passes once in 1e5, by Gumbel's law",
       rarely_passed(worst_of_seed));
}

// As if the glossy lobe had another alpha: what of it is diffuse goes with its square.
Mixture<double> with_alpha(Mixture<double> m, double alpha) {
  const Rgb<double> glossy = m.glossy * ((1 - alpha * alpha) / (1 - m.alpha * m.alpha));
  m.diffuse = m.diffuse + m.glossy - glossy;
  m.glossy = glossy;
  m.alpha = alpha;
  return m;
}

// As if kStretch were so many times what it is.
Mixture<double> stretched(const Mixture<double>& m, double times) {
  const double square = m.alpha * m.alpha;
  const double scaled = square / (1 - square) * times * times;
  return with_alpha(m, std::max(std::sqrt(scaled / (1 + scaled)), kLeastRoughness));
}

void compare_lightness(const std::vector<std::pair<SeenPaint, ByAngle>>& all) {
  std::vector<double> two_lobes, diffuse, best, ratio, shiny, grazing;
  std::map<double, std::vector<double>> of_stretch;
  for (const auto& [seen, walked] : all) {
    const Mixture<double> m =
        mixture(make_layer<double>(seen.paint), seen.substrate, seen.cos_view);
    const auto error = [&](const Mixture<double>& other) {
      return lightness_error(seen, other, walked);
    };
    two_lobes.push_back(error(m).two_lobes);
    diffuse.push_back(error(m).diffuse);
    if (is_shiny(seen.paint)) {
      shiny.push_back(diffuse.back() > 2 * two_lobes.back() ? 1 : 0);
    }
    // What the lobes show of light 15 degrees above the surface, of what the walk does.
    const GlossyLobe lobe(seen.cos_view, m.alpha);
    const Ramp<double> ramp = make_ramp(make_layer<double>(seen.paint));
    const std::vector<Vec3<double>> lights = directions();
    for (std::size_t i : {std::size_t{0}, kDirections - std::size_t{1}}) {
      const double mixed = walked.whole[i] - walked.single[i];
      const double shown =
          m.diffuse.x * diffuse_factor(ramp, lights[i].z) + m.glossy.x * lobe(lights[i]);
      if (seen.cos_view > 0.9 && mixed > 0.02) grazing.push_back(shown / mixed);
    }
    for (int i = -6; i <= 6; ++i) {
      const double times = std::exp(0.1 * i);
      of_stretch[kStretch * times].push_back(error(stretched(m, times)).two_lobes);
    }
    // The alpha that suits this paint best.
    const double alpha = m.alpha;
    double least = two_lobes.back(), at = alpha;
    for (double other = 0.02; other < 1; other *= 1.1) {
      const double found = error(with_alpha(m, other)).two_lobes;
      if (found < least) {
        least = found;
        at = other;
      }
    }
    best.push_back(least);
    // Of lobes that are seen at all.
    if (m.glossy.x > 0.05) ratio.push_back(std::fabs(std::log(alpha / at)));
  }
  tell("by angle: paints", static_cast<double>(all.size()));
  tell_quantiles("by angle: error in L*", two_lobes);
  tell("by angle: error in L*, mean", mean(two_lobes));
  tell("by angle: error in L*, standard deviation", deviation(two_lobes));
  tell("by angle: error in L* with one diffuse lobe, mean", mean(diffuse));
  tell("by angle: error in L* with one diffuse lobe, 95 %", quantile(diffuse, 0.95));
  tell("by angle: error in L* with one diffuse lobe, largest", quantile(diffuse, 1));
  tell("by angle: share of the shiny paints where that errs more than twice as much", mean(shiny));
  tell("by angle: M shown over walked, view at 14 degrees, light at 75, median",
       quantile(grazing, 0.5));
  tell("by angle: likewise, largest", quantile(grazing, 1));
  tell("by angle: likewise, least", quantile(grazing, 0));
  tell("by angle: error in L* with the best alpha for each paint, mean", mean(best));
  tell("alpha over the best, where the lobe's albedo > 0.05: factor either way, median",
       std::exp(quantile(ratio, 0.5)));
  tell("alpha over the best: factor either way, 95 %", std::exp(quantile(ratio, 0.95)));
  for (const auto& [stretch, errors] : of_stretch) {
    char name[80];
    std::snprintf(name, sizeof name, "kStretch %.3f: error in L*, mean", stretch);
    tell(name, mean(errors));
  }
}

void compare(const std::string& file) {
  const Found found = read(file);
  std::printf("| seeds | %zu, in a row from%s |\n", found.walked[0].size(), found.runs.c_str());
  compare_walks("own colours", found, 0, false);
  compare_walks("library but silica", found, 1, false);
  compare_walks("library with silica", found, 1, true);
  for (std::size_t k = 0; k < std::size(kLossless); ++k) {
    compare_furnace(kLossless[k], found.lossless[k]);
  }
  compare_lightness(found.by_angle);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> words(argv + 1, argv + argc);
    if (words.size() == 2 && words[0] == "compare") {
      compare(words[1]);
    } else if (words.size() >= 2 && words.size() <= 4 && words[0] == "walk") {
      std::random_device system;
      const std::uint64_t fresh = std::uint64_t{system()} << 32 | system();
      walk(words[1], words.size() > 2 ? std::stoi(words[2]) : 200,
           words.size() > 3 ? std::stoull(words[3]) : fresh);
    } else {
      std::cerr << "mixture_error walk FILE [SEEDS [FIRST]], or mixture_error compare FILE\n";
      return 2;
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
