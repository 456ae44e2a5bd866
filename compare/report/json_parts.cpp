// SPDX-License-Identifier: MIT
#include "compare/report/json_parts.h"

namespace alidade {

Json thresholds_json(const Verdict& verdict) {
  Json thresholds = Json::array();
  for (const JudgedThreshold& judged : verdict.judged) {
    thresholds.push_back({{"threshold", to_text(judged.threshold)},
                          {"metric", judged.threshold.metric},
                          {"fails_if", judged.fails_below ? "below" : "above"},
                          {"limit", json_number(judged.threshold.limit)},
                          {"value", json_number(judged.value)},
                          {"fails", judged.fails}});
  }
  return thresholds;
}

Json regions_json(const ChangeRegions& changes) {
  Json regions = Json::array();
  for (const ChangeRegion& region : changes.regions) {
    regions.push_back({{"left", region.left},
                       {"top", region.top},
                       {"right", region.right},
                       {"bottom", region.bottom},
                       {"pixels", region.pixels},
                       {"strongest", json_number(region.strongest)},
                       {"mean", json_number(region.mean)},
                       {"at", {region.x, region.y}}});
  }
  return regions;
}

}  // namespace alidade
