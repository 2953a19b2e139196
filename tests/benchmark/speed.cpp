// SPDX-License-Identifier: Apache-2.0
//
// The core's speed, pixel after pixel in one thread (Google Benchmark). ./paint bench measures the
// batches over numpy arrays beside it.
#include <benchmark/benchmark.h>

#include <vector>

#include "choices.h"
#include "scene.h"

namespace {

using namespace trade;

constexpr int kSize = 64;  // pixels along each side

// The sparkles of one light in each pixel of the ball.
template <class T>
void pixel_light(benchmark::State& state, const Scene& scene) {
  const Picture picture = look(scene, kSize);
  const auto model = shipped<T>()(scene);
  model->load(picture.points);
  std::vector<Drawn> drawn;
  int seed = 0;
  for (auto _ : state) {
    model->draw(seed++, drawn);
    benchmark::DoNotOptimize(drawn.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(picture.points.size()));
}

template <class T>
void make_paint(benchmark::State& state) {
  Paint paint;
  for (auto _ : state) {
    benchmark::DoNotOptimize(paint);
    benchmark::DoNotOptimize(make_layer<T>(paint));
  }
}

void register_all() {
  const std::vector<Scene> all = scenes();
  for (const auto& [name, scene] : {std::pair{"small", all[0]}, std::pair{"large", all[2]}}) {
    const auto add = [&](const char* type, const auto& run) {
      benchmark::RegisterBenchmark((std::string(type) + ", " + name + " mean count").c_str(), run,
                                   scene);
    };
    add("double", pixel_light<double>);
    add("float", pixel_light<float>);
  }
  benchmark::RegisterBenchmark("making a paint, double", make_paint<double>);
  benchmark::RegisterBenchmark("making a paint, float", make_paint<float>);
}

}  // namespace

int main(int count, char** arguments) {
  register_all();
  benchmark::Initialize(&count, arguments);
  if (benchmark::ReportUnrecognizedArguments(count, arguments)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
