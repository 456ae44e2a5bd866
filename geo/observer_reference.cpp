// SPDX-License-Identifier: MIT
#include "geo/observer_reference.h"

#include "geo/cloud_transformation.h"

namespace alidade {

void to_cloud_reference(std::vector<GivenObserver>& observers, const std::string& own,
                        const ObserverReference& reference) {
  if (observers.empty()) return;
  const GdalTransformation transformation = transformation_to_cloud(own, reference, observers.front().source);
  if (!transformation) return;
  for (GivenObserver& observer : observers)
    observer.place = transformed(observer.place, transformation, observer.source);
}

}  // namespace alidade
