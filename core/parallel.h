// SPDX-License-Identifier: Apache-2.0
//
// Work over all cores.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <stop_token>
#include <thread>
#include <vector>

namespace metallic_paint {

// Calls work(i) for i in [0, count) on all cores, in blocks. Leaves the rest undone once `stop` is
// requested, and where work throws: what it threw first comes out of here.
template <class Work>
void parallel_for(std::size_t count, const Work& work, std::size_t block_size = 1024,
                  const std::stop_token& stop = {}) {
  const std::size_t blocks = (count + block_size - 1) / block_size;
  // Asked each time, the system reads files to tell how many cores there are.
  static const std::size_t cores = std::thread::hardware_concurrency();
  const std::size_t workers = std::clamp<std::size_t>(cores, 1, std::max<std::size_t>(blocks, 1));
  std::atomic<std::size_t> next{0};
  std::atomic_flag failed;
  std::exception_ptr failure;
  const auto run = [&] {
    try {
      for (std::size_t block = next++; block < blocks && !stop.stop_requested(); block = next++) {
        const std::size_t end = std::min(count, (block + 1) * block_size);
        for (std::size_t i = block * block_size; i < end; ++i) work(i);
      }
    } catch (...) {
      if (!failed.test_and_set()) failure = std::current_exception();
      next = blocks;
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 1; i < workers; ++i) threads.emplace_back(run);
    run();
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace metallic_paint
