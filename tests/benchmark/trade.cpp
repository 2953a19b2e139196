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
#include "laws.h"
#include "measure.h"

namespace {

using namespace trade;

struct Effort {
  int size, rounds;
  std::size_t timed_pixels;
  int judged_pixels, draws, traced_pixels;
  int traced_size, traced_judged_pixels, traced_draws;  // against whole pictures of traced flakes
  std::size_t scenes, short_draws, papers_draws;
};
constexpr Effort kFull{256, 25, 8192, 12, 8192, 16384, 80, 6, 512, 6, 1 << 22, 1 << 17};
constexpr Effort kQuick{96, 9, 2048, 6, 2048, 4096, 24, 3, 64, 3, 1 << 18, 1 << 13};

constexpr int kSeed = 1, kOtherSeed = 2;
constexpr float kOtherSparkles = 1;

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
  const auto exact = model<double, OneByOne>()(scene);
  const auto other_sums = model<double, OneByOne>({}, {kOtherSparkles})(scene);
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

void write_laws(std::ostream& out, const Effort& effort) {
  out << "\"laws\": ";
  write_list(out, law_cases(), [&](const LawCase& law) {
    out << "{\"name\": " << quoted(law.name) << ", \"rows\": ";
    write_list(out, kMeanCounts, [&](double mean_count) {
      const Law found = law_of(law, mean_count, effort.short_draws, effort.papers_draws);
      out << "  {\"count\": " << found.mean_count << ", \"mean\": " << found.mean
          << ", \"mean_error\": " << found.mean_error << ", \"variance\": " << found.variance
          << ", \"variance_error\": " << found.variance_error
          << ", \"skewness\": " << found.skewness
          << ", \"papers_skewness\": " << found.papers_skewness
          << ", \"distance\": " << found.distance << ", \"noise\": " << found.noise << '}';
    });
    out << '}';
  });
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
    {"all together", "as shipped"}, {"all together", "everything exact, in double"},
    {"depth", "attenuated"},        {"depth", "thinned"},
    {"radiometry", "published"},    {"draw", "N × mean sparkle"},
    {"draw", "mean only, no draw"}};

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
  std::cout << "Drawing sparkle after sparkle…" << std::endl;
  write_laws(out, effort);
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
