// SPDX-License-Identifier: Apache-2.0
//
// What each choice costs and how far it is from the exact one: trade FOLDER [--quick]. Writes
// measurements.json and the pictures (raw floats) that tools/accuracy/report.py makes a report of.
#include <cstring>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <random>
#include <stdexcept>
#include <utility>

#include "choices.h"
#include "explicit.h"
#include "measure.h"

namespace {

using namespace trade;

struct Effort {
  int size, rounds;
  std::size_t timed_pixels;
  int judged_pixels, draws, draws_of_sums, traced_pixels;
  int traced_size, traced_judged_pixels, traced_draws;  // against whole pictures of traced flakes
  std::size_t scenes;
};
constexpr Effort kFull{256, 25, 8192, 12, 8192, 1 << 17, 16384, 80, 6, 512, 6};
constexpr Effort kQuick{96, 9, 2048, 6, 2048, 1 << 15, 4096, 24, 3, 64, 3};

constexpr int kSeed = 1, kOtherSeed = 2;
constexpr int kOtherSparkles = 1 << 24;  // draws from here on are no other sum's

struct Measured {
  std::string group;
  Option option;
  bool exact = false, shipped = false, copy = false;  // copy: draws the shipped draws
  std::unique_ptr<Model> model;
  double seconds_to_make = 0;   // its tables
  std::vector<double> seconds;  // per pixel, of each round
  Errors error;
  std::string picture;
};

std::vector<Measured> make_models(const Scene& scene) {
  std::vector<Measured> all;
  for (const Group& group : groups()) {
    for (const Option& option : group.options) {
      Measured m;
      m.group = group.name;
      m.option = option;
      m.exact = option.name == group.exact;
      m.shipped = option.name == group.shipped;
      m.copy = m.shipped && group.default_paint;
      const std::clock_t start = std::clock();
      m.model = option.make(scene);
      m.seconds_to_make = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
      all.push_back(std::move(m));
    }
  }
  return all;
}

// `count` points evenly through `points`.
std::vector<SurfacePoint<double>> some(const std::vector<SurfacePoint<double>>& points,
                                       std::size_t count) {
  std::vector<SurfacePoint<double>> chosen;
  for (std::size_t i = 0; i < count; ++i) {
    chosen.push_back(points[(2 * i + 1) * points.size() / (2 * count)]);
  }
  return chosen;
}

// Pixels for the statistics: as many sparkles as there are about the brightest ones and down to a
// thousandth of that, but not so few that nothing can be said of them.
std::vector<SurfacePoint<double>> pixels_to_judge(const Scene& scene, const Picture& picture,
                                                  int count) {
  const Layer<double> layer = make_layer<double>(scene.paint);
  std::vector<std::pair<double, SurfacePoint<double>>> by_count;
  for (const SurfacePoint<double>& point : picture.points) {
    const double mean =
        expect_sparkles(layer, point, see_light(scene.light, point.position)).mean_count;
    by_count.emplace_back(mean, point);
  }
  std::sort(by_count.begin(), by_count.end(),
            [](const auto& a, const auto& b) { return a.first > b.first; });
  const double most = by_count.front().first, least = std::max(most * 1e-3, 0.05);
  std::vector<SurfacePoint<double>> chosen;
  for (int i = 0; i < count; ++i) {
    const double wanted = most * std::pow(least / most, (i + 0.5) / count);
    const auto at = std::find_if(by_count.begin(), by_count.end(),
                                 [&](const auto& p) { return p.first <= wanted; });
    chosen.push_back(at == by_count.end() ? by_count.back().second : at->second);
  }
  return chosen;
}

// Processor time of this one thread, per pixel.
double time_once(const Model& model, std::size_t pixels) {
  static std::vector<Drawn> drawn;
  const std::clock_t start = std::clock();
  model.draw(kSeed, drawn);
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / static_cast<double>(pixels);
}

// Every model in every round once, in random order: what disturbs the machine disturbs all alike.
void time_models(std::vector<Measured>& all, const std::vector<SurfacePoint<double>>& points,
                 const Effort& effort) {
  const auto few = some(points, 256), many = some(points, effort.timed_pixels);
  std::vector<std::size_t> pixels(all.size());
  std::vector<std::size_t> order(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i].model->load(few);
    const bool slow = time_once(*all[i].model, few.size()) > 5e-6;
    if (!slow) all[i].model->load(many);
    pixels[i] = slow ? few.size() : many.size();
    order[i] = i;
  }
  std::mt19937 engine(7);
  for (int round = 0; round < effort.rounds; ++round) {
    std::shuffle(order.begin(), order.end(), engine);
    for (std::size_t i : order) all[i].seconds.push_back(time_once(*all[i].model, pixels[i]));
  }
}

std::vector<Draws> draws_of(Model& model, const std::vector<SurfacePoint<double>>& points,
                            int count, int first_seed) {
  model.load(points);
  std::vector<Draws> pixels(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (const Drawn& drawn : model.draw_again(i, first_seed, count)) {
      pixels[i].count.push_back(drawn.count);
      pixels[i].radiance.push_back(luminance(drawn.radiance));
    }
  }
  return pixels;
}

void write_floats(const std::filesystem::path& file, const std::vector<float>& values) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size() * sizeof(float)));
  if (!out) throw std::runtime_error("cannot write " + file.string());
}

void write_picture(const std::vector<Rgb<double>>& radiance, const Picture& picture,
                   const std::filesystem::path& file) {
  std::vector<float> image(picture.base.size() * 3, 0);
  for (std::size_t i = 0; i < radiance.size(); ++i) {
    const SurfacePoint<double>& p = picture.points[i];
    const std::size_t at = 3 * static_cast<std::size_t>(p.pixel_y * picture.size + p.pixel_x);
    image[at] = static_cast<float>(radiance[i].x);
    image[at + 1] = static_cast<float>(radiance[i].y);
    image[at + 2] = static_cast<float>(radiance[i].z);
  }
  write_floats(file, image);
}

void paint_picture(Model& model, const Picture& picture, int seed,
                   const std::filesystem::path& file) {
  std::vector<Drawn> drawn;
  model.load(picture.points);
  model.draw(seed, drawn);
  std::vector<Rgb<double>> radiance;
  for (const Drawn& d : drawn) radiance.push_back(d.radiance);
  write_picture(radiance, picture, file);
}

// The alternatives repeat the core's code; with the core's own numbers they must give its draws.
void check_alternatives(const Scene& scene, const std::vector<SurfacePoint<double>>& points) {
  std::vector<Drawn> a, b;
  const auto core = shipped()(scene);
  const auto repeated = model<float, Alternative<CoreCount, CoreSum>>()(scene);
  core->load(points);
  repeated->load(points);
  core->draw(kSeed, a);
  repeated->draw(kSeed, b);
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].count != b[i].count || a[i].radiance.x != b[i].radiance.x) {
      throw std::runtime_error("alternatives.h no longer repeats the core's draw of a pixel");
    }
  }
}

// ---------------------------------------------------------------------------------------------
// JSON

std::string quoted(const std::string& text) { return '"' + text + '"'; }

template <class Items, class Write>
void write_list(std::ostream& out, const Items& items, const Write& write) {
  out << '[';
  bool first = true;
  for (const auto& item : items) {
    out << (first ? "\n" : ",\n");
    first = false;
    write(item);
  }
  out << ']';
}

void write_errors(std::ostream& out, const Errors& e) {
  out << "{\"count\": " << e.count << ", \"mean\": " << e.mean << ", \"deviation\": " << e.deviation
      << ", \"distribution\": " << e.distribution << '}';
}

const char* text(Numbers numbers) {
  return numbers == Numbers::same ? "same" : numbers == Numbers::counts ? "counts" : "own";
}

void write_scene(std::ostream& out, const std::filesystem::path& folder, const Scene& scene,
                 const Effort& effort) {
  const Picture picture = look(scene, effort.size);
  check_alternatives(scene, picture.points);
  std::vector<Measured> all = make_models(scene);
  time_models(all, picture.points, effort);

  const auto judged = pixels_to_judge(scene, picture, effort.judged_pixels);
  for (const Group& group : groups()) {
    std::vector<Measured*> members;
    for (Measured& m : all) {
      if (m.group == group.name) members.push_back(&m);
    }
    const auto exact =
        std::find_if(members.begin(), members.end(), [](const Measured* m) { return m->exact; });
    const auto reference = draws_of(*(*exact)->model, judged, effort.draws, kSeed);
    for (Measured* m : members) {
      if (!m->exact) {
        m->error = errors(draws_of(*m->model, judged, effort.draws, kSeed), reference);
      }
    }
  }
  // What other random numbers alone do.
  const auto exact = model<double, Exact>()(scene);
  const auto other_sums = model<double, Exact>({}, {{}, {kOtherSparkles}})(scene);
  const auto reference = draws_of(*exact, judged, effort.draws, kSeed);
  const Errors floor_counts = errors(draws_of(*other_sums, judged, effort.draws, kSeed), reference);
  const Errors floor_own =
      errors(draws_of(*exact, judged, effort.draws, kSeed + effort.draws), reference);

  int number = 0;
  for (Measured& m : all) {
    m.picture = scene.name + "-" + std::to_string(number++) + ".raw";
    paint_picture(*m.model, picture, kSeed, folder / m.picture);
  }
  paint_picture(*exact, picture, kSeed, folder / (scene.name + "-exact.raw"));
  paint_picture(*other_sums, picture, kSeed, folder / (scene.name + "-counts.raw"));
  paint_picture(*exact, picture, kOtherSeed, folder / (scene.name + "-own.raw"));
  write_floats(folder / (scene.name + "-base.raw"), picture.base);

  const Layer<double> layer = make_layer<double>(scene.paint);
  const SurfacePoint<double>& brightest = *std::max_element(
      picture.points.begin(), picture.points.end(), [&](const auto& a, const auto& b) {
        return expect_sparkles(layer, a, see_light(scene.light, a.position)).mean_count <
               expect_sparkles(layer, b, see_light(scene.light, b.position)).mean_count;
      });
  out << "{\"name\": " << quoted(scene.name) << ", \"pixel\": " << scene.pixel
      << ", \"tilt\": " << scene.paint.tilt << ", \"sparkles\": "
      << expect_sparkles(layer, brightest, see_light(scene.light, brightest.position)).mean_count
      << ", \"flakes\": " << layer.flakes[0].areal_density * brightest.footprint
      << ", \"draws\": " << effort.draws << ", \"judged\": " << judged.size()
      << ",\n \"floor\": {\"counts\": ";
  write_errors(out, floor_counts);
  out << ", \"own\": ";
  write_errors(out, floor_own);
  out << "},\n \"options\": ";
  write_list(out, all, [&](const Measured& m) {
    out << "  {\"group\": " << quoted(m.group) << ", \"name\": " << quoted(m.option.name)
        << ", \"exact\": " << (m.exact ? "true" : "false")
        << ", \"shipped\": " << (m.shipped ? "true" : "false")
        << ", \"copy\": " << (m.copy ? "true" : "false")
        << ", \"seconds_to_make\": " << m.seconds_to_make
        << ", \"numbers\": " << quoted(text(m.option.numbers))
        << ", \"picture\": " << quoted(m.picture) << ", \"error\": ";
    write_errors(out, m.error);
    out << ", \"seconds\": ";
    write_list(out, m.seconds, [&](double s) { out << s; });
    out << '}';
  });
  out << '}';
}

constexpr double kSamplerMeans[] = {0.03, 0.09, 0.1, 0.3, 1, 3, 10, 31.9, 32, 100, 300, 1000};

template <class Count>
void write_sampler(std::ostream& out, const std::string& name, const char* comma = ",") {
  out << "\n {\"name\": " << quoted(name) << ", \"total_variation\": ";
  write_list(out, kSamplerMeans, [&](double m) { out << total_variation(Count{}, m); });
  out << '}' << comma;
}

void write_samplers(std::ostream& out) {
  using enum Form;
  out << "\"means\": ";
  write_list(out, kSamplerMeans, [&](double m) { out << m; });
  out << ",\n\"samplers\": [";
  write_sampler<Inversion>(out, "inversion");
  write_sampler<CoreCount>(out, "Cornish–Fisher from 32 (shipped)");
  write_sampler<InversionThen<cornish_fisher, 0>>(out, "Cornish–Fisher");
  write_sampler<InversionThen<wilson_hilferty, 0>>(out, "Wilson–Hilferty");
  write_sampler<InversionThen<normal, 0>>(out, "rounded normal");
  write_sampler<Bernoulli>(out, "Bernoulli below 0.1", "");
  out << ']';
}

constexpr int kSumCounts[] = {1, 2, 4, 5, 8, 12, 16, 17, 24, 33, 48, 64, 65, 100};

// The law of the sum of N sparkles in a middling pixel of `scene`: its Wasserstein distance from
// the exact one in standard deviations sqrt(<N> E[Y^2]) of the pixel's whole sum, <N> = N.
class SumLaws {
 public:
  SumLaws(const Scene& scene, int draws) : draws_(draws), spread_(scene.paint.flake_area_spread) {
    const auto point = pixels_to_judge(scene, look(scene, 64), 1).front();
    expected_ = expect_sparkles(make_layer<double>(scene.paint), point,
                                see_light(scene.light, point.position));
    for (int n : kSumCounts) exact_.push_back(drawn(EachDrawn{}, n));
  }

  template <class Sum>
  std::vector<double> distances(const Sum& sum) const {
    const double second = luminance(mean_square_sparkle(expected_));
    std::vector<double> distances;
    for (std::size_t i = 0; i < exact_.size(); ++i) {
      distances.push_back(wasserstein(drawn(sum, kSumCounts[i]), exact_[i]) /
                          std::sqrt(kSumCounts[i] * second));
    }
    return distances;
  }

 private:
  template <class Sum>
  std::vector<double> drawn(const Sum& sum, int count) const {
    std::vector<double> values;
    for (int i = 0; i < draws_; ++i) {
      const HashWords key = stream_key(0, 0, 0, i);
      values.push_back(luminance(sum(expected_, spread_, key, 0, 0, draw_words(key, 0, 0, 0),
                                     static_cast<double>(count))));
    }
    return values;
  }

  int draws_;
  double spread_;
  ExpectedSparkles<double> expected_;
  std::vector<std::vector<double>> exact_;
};

void write_sums(std::ostream& out, const SumLaws& laws) {
  const auto write = [&](const char* name, const std::vector<double>& distances,
                         const char* comma = ",") {
    out << "\n {\"name\": " << quoted(name) << ", \"distribution\": ";
    write_list(out, distances, [&](double d) { out << d; });
    out << '}' << comma;
  };
  out << "\"counts\": ";
  write_list(out, kSumCounts, [&](int n) { out << n; });
  out << ",\n\"sums\": [";
  write("each drawn, other numbers", laws.distances(EachDrawn{kOtherSparkles}));
  write("64 drawn, then skewed normal", laws.distances(DrawnThenSkewed<64>{}));
  write("16 drawn, then skewed normal", laws.distances(CoreSum{}));
  write("8 drawn, then skewed normal", laws.distances(DrawnThenSkewed<8>{}));
  write("4 drawn, then skewed normal", laws.distances(DrawnThenSkewed<4>{}));
  write("skewed normal always", laws.distances(DrawnThenSkewed<0>{}));
  write("16 drawn, then normal", laws.distances(DrawnThenNormal<16>{}));
  write("N × mean sparkle", laws.distances(CountTimesMean{}), "");
  out << ']';
}

void write_explicit(std::ostream& out, int pixels) {
  out << "\"explicit\": ";
  write_list(out, explicit_cases(), [&](const ExplicitCase& c) {
    const ExplicitFound f = trace(c, pixels);
    const auto share = [&](const char* name, Share s) {
      out << quoted(name) << ": {\"mean\": " << s.mean << ", \"square\": " << s.square << "}, ";
    };
    out << "{\"varied\": " << quoted(c.varied) << ", \"value\": " << c.value
        << ", \"count\": " << f.count << ", ";
    share("traced", f.traced);
    for (std::size_t i = 0; i < std::size(kDepthModels); ++i) {
      share(kDepthModels[i].first, f.share[i]);
    }
    out << "\"deviation_of_mean\": " << f.deviation_of_mean
        << ", \"deviation_of_square\": " << f.deviation_of_square << ", \"distance\": {";
    for (std::size_t i = 0; i < std::size(kDepthModels); ++i) {
      out << quoted(kDepthModels[i].first) << ": " << f.distance[i] << ", ";
    }
    out << "\"floor\": " << f.floor << "}, \"flakes\": " << f.flakes
        << ", \"seconds\": " << f.seconds << '}';
  });
}

// The group's options that are held against traced flakes too.
constexpr std::pair<const char*, const char*> kHeldAgainstTraced[] = {
    {"all together", "as shipped"},
    {"all together", "everything exact, in double"},
    {"depth", "attenuated"},
    {"depth", "thinned"},
    {"radiometry", "published"},
    {"sum over N", "N × mean sparkle"},
    {"sum over N", "mean only, no draw"}};

// The nearest scene with every flake traced: what the model as a whole, not only its draw, costs
// and errs.
void write_traced(std::ostream& out, const std::filesystem::path& folder, const Effort& effort) {
  const Scene scene = scenes().front();
  const Picture picture = look(scene, effort.traced_size);
  write_floats(folder / "traced-base.raw", picture.base);
  const auto model = shipped()(scene);
  const std::clock_t start = std::clock();  // of all threads
  for (int seed : {kSeed, kOtherSeed}) {
    write_picture(trace_picture(scene, picture, seed), picture,
                  folder / ("traced-" + std::to_string(seed) + ".raw"));
  }
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC /
                         (2 * static_cast<double>(picture.points.size()));
  for (int seed : {kSeed, kOtherSeed}) {
    paint_picture(*model, picture, seed,
                  folder / ("traced-model-" + std::to_string(seed) + ".raw"));
  }
  const auto judged = pixels_to_judge(scene, picture, effort.traced_judged_pixels);
  const auto traced = trace_draws(scene, judged, effort.traced_draws, kSeed);
  out << "\"traced\": {\"scene\": " << quoted(scene.name) << ", \"size\": " << picture.size
      << ", \"seconds\": " << seconds << ", \"judged\": " << judged.size()
      << ", \"draws\": " << effort.traced_draws << ", \"floor\": ";
  write_errors(out, errors(trace_draws(scene, judged, effort.traced_draws, kOtherSeed), traced));
  out << ", \"options\": ";
  const std::vector<Group> all = groups();
  write_list(out, kHeldAgainstTraced, [&](const auto& held) {
    const auto named = [](const char* name) {
      return [name](const auto& item) { return item.name == name; };
    };
    const auto group = std::find_if(all.begin(), all.end(), named(held.first));
    const auto option =
        std::find_if(group->options.begin(), group->options.end(), named(held.second));
    const auto drawing = option->make(scene);
    out << "{\"group\": " << quoted(held.first) << ", \"name\": " << quoted(held.second)
        << ", \"error\": ";
    write_errors(out, errors(draws_of(*drawing, judged, effort.traced_draws, kSeed), traced));
    out << '}';
  });
  out << '}';
}

void run(const std::filesystem::path& folder, const Effort& effort) {
  std::ofstream out(folder / "measurements.json");
  out.precision(8);
  out << "{\"size\": " << effort.size << ",\n\"scenes\": ";
  std::vector<Scene> measured = scenes();
  measured.resize(effort.scenes);
  write_list(out, measured, [&](const Scene& scene) {
    std::cout << "Measuring: " << scene.name << "…" << std::endl;
    write_scene(out, folder, scene, effort);
  });
  out << ",\n";
  write_samplers(out);
  out << ",\n";
  write_sums(out, SumLaws(scenes()[1], effort.draws_of_sums));
  std::cout << "Tracing flakes one by one…" << std::endl;
  out << ",\n";
  write_explicit(out, effort.traced_pixels);
  out << ",\n";
  write_traced(out, folder, effort);
  out << "}\n";
  out.close();
  if (!out) throw std::runtime_error("cannot write " + (folder / "measurements.json").string());
}

}  // namespace

int main(int count, char** arguments) {
  const bool quick = count == 3 && std::strcmp(arguments[2], "--quick") == 0;
  if (count != 2 && !quick) {
    std::cerr << "Usage: trade FOLDER [--quick]\n";
    return 2;
  }
  try {
    run(arguments[1], quick ? kQuick : kFull);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  return 0;
}
