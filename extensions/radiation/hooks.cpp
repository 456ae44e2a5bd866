// SPDX-License-Identifier: MIT
#include <memory>

#include "extensions/radiation/job.h"

namespace alidade::extensions {
namespace {

std::shared_ptr<jobs::AddedSunMeasure> make_radiation() {
  return std::make_shared<jobs::AddedRadiation>();
}

}  // namespace

void set_up_radiation() {
  jobs::add_addition<jobs::AddedSunMeasure>(make_radiation);
}

}  // namespace alidade::extensions
