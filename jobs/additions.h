// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <vector>

#include "jobs/fields.h"

// What extensions add to jobs of the core.

namespace alidade::jobs {

/// Fields of an extension beside those of a job. Each job that has additions derives the interface by which it
/// uses them, such as AddedLineMeasure.
class Addition {
 public:
  virtual ~Addition() = default;
  virtual void add_fields(const Fields& fields) = 0;
};

template <class Added>
using MakeAddition = std::shared_ptr<Added> (*)();

template <class Added>
std::vector<MakeAddition<Added>>& added_makers() {
  static std::vector<MakeAddition<Added>> makers;
  return makers;
}

/// Adds something to every request of a job. To be called before requests are made.
template <class Added>
void add_addition(MakeAddition<Added> make) {
  added_makers<Added>().push_back(make);
}

/// The additions to a request, which its copies share.
template <class Added>
using Additions = std::vector<std::shared_ptr<Added>>;

/// One of each.
template <class Added>
Additions<Added> make_additions() {
  Additions<Added> additions;
  for (const MakeAddition<Added> make : added_makers<Added>()) additions.push_back(make());
  return additions;
}

}  // namespace alidade::jobs
