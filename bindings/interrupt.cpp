// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <future>

#include "module.h"

namespace py = pybind11;

// Python calls its handlers of signals in its own thread only, and only when asked to.
void interruptible(const std::function<void(const std::stop_token&)>& work, bool brief) {
  constexpr std::chrono::milliseconds kBetweenLooks{20};
  const py::gil_scoped_release released;
  if (brief) return work({});
  std::stop_source stop;
  std::future<void> done = std::async(std::launch::async, [&] { work(stop.get_token()); });
  while (done.wait_for(kBetweenLooks) != std::future_status::ready) {
    const py::gil_scoped_acquire held;
    if (PyErr_CheckSignals() == 0) continue;
    stop.request_stop();
    done.wait();
    throw py::error_already_set();
  }
  done.get();
}
